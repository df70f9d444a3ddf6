#include "firmware/keep/database.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_database_test {

TEST(Database, a_file_of_any_name_is_the_one_that_is_opened) {
  const tests::TemporaryFolder folder;
  for (const char* name :
       {"plain.sqlite", "a%b.sqlite", "a?mode=ro.sqlite", "a#b.sqlite", "%41?#.sqlite", "z\xc3\xa4 o.sqlite"}) {
    const std::string path = folder.file(name);
    Database(path, Database::Mode::write).run("CREATE TABLE a (b); INSERT INTO a VALUES (7)");
    EXPECT_TRUE(std::filesystem::exists(path)) << name;
    EXPECT_EQ(Database(path, Database::Mode::read).whole("SELECT b FROM a"), 7) << name;
  }
  EXPECT_EQ(folder.files(), 6);
}

TEST(Database, what_is_bound_comes_back_in_its_place_and_no_number_as_none) {
  const tests::TemporaryFolder folder;
  Database database(folder.file("a.sqlite"), Database::Mode::write);
  database.run("CREATE TABLE a (i INTEGER, x REAL, t TEXT, n REAL)");
  Statement insert = database.prepare("INSERT INTO a VALUES (?, ?, ?, ?)");
  for (const std::int64_t value : {std::int64_t{3}, std::int64_t{-1} << 40}) {
    insert.bind(0, value);
    insert.bind(1, 0.1);
    insert.bind(2, std::string("it's \"one\""));
    insert.bind(3, std::numeric_limits<double>::infinity());
    insert.run();
  }
  Statement all = database.prepare("SELECT i, x, t, n AS \"last one\" FROM a ORDER BY i DESC");
  EXPECT_EQ(all.columns(), 4);
  EXPECT_EQ(all.column_name(3), "last one");
  for (const std::int64_t value : {std::int64_t{3}, std::int64_t{-1} << 40}) {
    ASSERT_TRUE(all.step());
    EXPECT_EQ(all.whole(0), value);
    EXPECT_EQ(all.number(1), 0.1);
    EXPECT_EQ(all.text(2), "it's \"one\"");
    EXPECT_TRUE(std::isnan(all.number(3)));
    EXPECT_EQ(all.text(3), "") << "there is none";
  }
  EXPECT_FALSE(all.step());
  EXPECT_EQ(database.whole("SELECT i FROM a WHERE i = 3"), 3);
  EXPECT_EQ(database.whole("SELECT i FROM a WHERE i = 4"), 0) << "no row";
}

TEST(Database, each_name_is_quoted_so_that_it_is_one) {
  EXPECT_EQ(quoted_name("a b"), "\"a b\"");
  EXPECT_EQ(quoted_name("a\"b\""), "\"a\"\"b\"\"\"");
  EXPECT_EQ(quoted_name(""), "\"\"");
}

TEST(Database, only_a_damaged_file_and_one_that_is_no_database_are_damage) {
  EXPECT_TRUE(DatabaseError(SQLITE_CORRUPT, "").is_damage());
  EXPECT_TRUE(DatabaseError(SQLITE_NOTADB, "").is_damage());
  for (const int other : {SQLITE_OK, SQLITE_ERROR, SQLITE_FULL, SQLITE_CANTOPEN, SQLITE_BUSY}) {
    EXPECT_FALSE(DatabaseError(other, "").is_damage()) << other;
  }
}

TEST(Database, what_it_cannot_do_is_an_error_with_sqlites_own_words) {
  const tests::TemporaryFolder folder;
  const auto error_of = [](const auto& work) {
    try {
      work();
    } catch (const DatabaseError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_EQ(error_of([&] { Database(folder.file("no.sqlite"), Database::Mode::read); }),
            "unable to open database file");
  Database database(folder.file("a.sqlite"), Database::Mode::write);
  EXPECT_EQ(error_of([&] { database.run("NONSENSE"); }), "near \"NONSENSE\": syntax error");
  EXPECT_EQ(error_of([&] { database.prepare("SELECT * FROM a"); }), "no such table: a");
  database.run("CREATE TABLE a (b UNIQUE); INSERT INTO a VALUES (1)");
  Statement twice = database.prepare("INSERT INTO a VALUES (1)");
  EXPECT_EQ(error_of([&] { twice.run(); }), "UNIQUE constraint failed: a.b");
  EXPECT_EQ(error_of([&] { database.prepare("INSERT INTO a VALUES (?)").bind(1, 2.0); }), "column index out of range");
  Database reader(folder.file("a.sqlite"), Database::Mode::read);
  EXPECT_EQ(error_of([&] { reader.run("INSERT INTO a VALUES (2)"); }), "attempt to write a readonly database");
}

}  // namespace keep_database_test
}  // namespace spindle_twin::firmware
