#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "rom/read/names.hpp"
#include "rom/read/strict_toml.hpp"
#include "tests/support/texts.hpp"

/// What a table is taken with up to its last number and letter, and what is said just beyond.
namespace spindle_twin::rom::tests {
namespace toml_edges_test {

using spindle_twin::tests::refusal_of;

TomlTable parse(const std::string& text) { return TomlTable::parse(text, "f.toml"); }

TEST(StrictTomlEdges, whole_numbers_are_taken_up_to_both_ends) {
  const TomlTable root = parse("a = -3\n");
  EXPECT_EQ(root.integer("a", -3, 7), -3);
  EXPECT_EQ(root.integer("a", -9, -3), -3);
  EXPECT_EQ(root.integer_or("a", 5, -3, -3), -3);
  EXPECT_EQ(root.integer_or("none", 5, 0, 9), 5);
  for (const auto& [least, most] : {std::pair{-2, 7}, {-9, -4}}) {
    EXPECT_EQ(
        refusal_of([&, from = least, to = most] { root.integer("a", from, to); }),
        "f.toml:1: a: must be an integer from " + std::to_string(least) + " to " + std::to_string(most) + ", is -3");
  }
}

TEST(StrictTomlEdges, names_are_of_letters_digits_and_underscores_and_begin_with_a_letter) {
  for (const std::string good : {"a", "z", "A", "Z", "a0", "m9", "x_", "zZ_09"}) {
    EXPECT_EQ(parse("name = \"" + good + "\"").name(), good);
  }
  for (const std::string bad :
       {"", "0a", "9", "_a", "a/", "a:", "a@", "a[", "a`", "a{", "a^", "@a", "[a", "`a", "{a", "a b", "a-b"}) {
    EXPECT_EQ(refusal_of([&] { parse("name = \"" + bad + "\"").name(); }),
              "f.toml:1: name: must be letters, digits and underscores and start with a letter, is \"" + bad + "\"");
  }
}

/// A table with one key that is not known, beside one that is asked for.
std::string said_of(const std::string& unknown, const std::vector<std::string>& known) {
  const TomlTable root = parse(unknown + " = 1\n");
  for (const std::string& key : known) root.has(key);
  const std::string said = refusal_of([&] { root.finish(); });
  const std::string begin = "f.toml:1: " + unknown + ": unknown key", end = "; allowed here: ";
  EXPECT_TRUE(said.starts_with(begin)) << said;
  return said.substr(begin.size(), said.find(end) - begin.size());
}

TEST(StrictTomlEdges, a_slip_of_two_letters_or_of_a_third_of_them_is_pointed_out) {
  EXPECT_EQ(said_of("abcd", {"abxy"}), ", did you mean \"abxy\"?");
  EXPECT_EQ(said_of("abcd", {"axyz"}), "") << "three letters of four";
  EXPECT_EQ(said_of("abcdefghi", {"abcdefxyz"}), ", did you mean \"abcdefxyz\"?") << "three of nine";
  EXPECT_EQ(said_of("abcdefgh", {"abcdexyz"}), "") << "three of eight";
  EXPECT_EQ(said_of("abcdefghi", {"abcdeuxyz"}), "") << "four of nine";
  EXPECT_EQ(said_of("speed", {"sped"}), ", did you mean \"sped\"?") << "one left out";
  EXPECT_EQ(said_of("sped", {"speeds"}), ", did you mean \"speeds\"?") << "two too many";
  EXPECT_EQ(said_of("load", {"laod"}), ", did you mean \"laod\"?") << "two in place of each other";
}

TEST(StrictTomlEdges, of_several_slips_the_nearest_is_pointed_out_and_of_two_alike_the_first) {
  EXPECT_EQ(said_of("abcd", {"abxy", "abcx", "axcy"}), ", did you mean \"abcx\"?");
  EXPECT_EQ(said_of("abcd", {"abcx", "abcy"}), ", did you mean \"abcx\"?");
}

TEST(StrictTomlEdges, free_keys_come_in_the_order_of_the_file_and_are_known_then) {
  const TomlTable table = parse("[t]\nzeta = 1\nalpha = 2\nmiddle = 3\n").table("t");
  EXPECT_EQ(table.free_keys(), (std::vector<std::string>{"zeta", "alpha", "middle"}));
  EXPECT_NO_THROW(table.finish());
  EXPECT_EQ(table.where("alpha").line, 3);
  EXPECT_EQ(table.where("none").line, table.where().line);
  EXPECT_EQ(table.path("alpha"), "t.alpha");
}

TEST(StrictTomlEdges, lists_of_any_length_of_that_length_and_of_none) {
  const TomlTable root = parse("none = []\none = [4.0]\ntables = []\nwords = []\n[[t]]\n[[t]]\n[u]\n");
  EXPECT_TRUE(root.numbers("none").empty());
  EXPECT_EQ(root.numbers("one"), std::vector<double>{4.0});
  EXPECT_EQ(root.numbers("one", 1), std::vector<double>{4.0});
  EXPECT_EQ(refusal_of([&] { root.numbers("one", 2); }),
            "f.toml:2: one: must be an array of 2 numbers, is an array of 1");
  EXPECT_EQ(refusal_of([&] { root.numbers("none", 1); }),
            "f.toml:1: none: must be an array of 1 numbers, is an array of 0");
  EXPECT_EQ(refusal_of([&] { root.numbers("u"); }), "f.toml:7: u: must be an array of numbers, is a table");
  EXPECT_EQ(refusal_of([&] { root.tables("tables"); }), "f.toml:3: tables: must hold at least one table");
  EXPECT_TRUE(root.tables_or_empty("nothing").empty());
  EXPECT_TRUE(root.strings("words").empty());
  EXPECT_TRUE(root.strings_or_empty("nothing").empty());
  EXPECT_EQ(root.tables("t").size(), 2U);
  EXPECT_TRUE(root.is_table("u"));
  EXPECT_FALSE(root.is_table("t"));
  EXPECT_FALSE(root.is_table("nothing"));
  EXPECT_FALSE(root.optional_table("nothing").has_value());
  EXPECT_EQ(root.tables("t")[1].path("key"), "t[2].key") << "counted from one";
}

TEST(StrictTomlEdges, what_is_missing_is_what_was_said_instead_and_nothing_else) {
  const TomlTable root = parse("on = true\noff = false\nword = \"yes\"\n");
  EXPECT_TRUE(root.boolean_or("on", false));
  EXPECT_FALSE(root.boolean_or("off", true));
  EXPECT_TRUE(root.boolean_or("nothing", true));
  EXPECT_FALSE(root.boolean_or("nothing", false));
  EXPECT_EQ(root.string_or("word", "no"), "yes");
  EXPECT_EQ(root.string_or("nothing", "no"), "no");
  EXPECT_EQ(root.optional_string("word"), "yes");
  EXPECT_FALSE(root.optional_string("nothing").has_value());
  EXPECT_EQ(root.choice_or("word", "no", {"yes", "no"}), "yes");
  EXPECT_EQ(root.choice_or("nothing", "no", {"yes", "no"}), "no");
}

TEST(StrictTomlEdges, a_name_is_found_at_its_place_and_a_pair_is_of_two) {
  const TomlTable root = parse(
      "[[n]]\nname = \"b\"\n[[n]]\nname = \"a\"\n[[n]]\nname = \"c\"\n[use]\none = \"a\"\npair = [\"c\", \"b\"]\n"
      "three = [\"a\", \"b\", \"c\"]\nsame = [\"a\", \"a\"]\nno = \"d\"\n");
  Names names("node");
  for (const TomlTable& table : root.tables("n")) names.add(table);
  const TomlTable use = root.table("use");
  EXPECT_EQ(names.find(use, "one"), 1U);
  EXPECT_EQ(names.find_pair(use, "pair"), (std::pair<std::size_t, std::size_t>{2, 0}));
  EXPECT_EQ(names.find_all(use, "three", use.strings("three")), (std::vector<std::size_t>{1, 0, 2}));
  EXPECT_NE(refusal_of([&] { names.find_pair(use, "three"); }), "accepted");
  EXPECT_NE(refusal_of([&] { names.find_pair(use, "same"); }), "accepted");
  EXPECT_EQ(refusal_of([&] { names.find(use, "no"); }),
            "f.toml:12: use.no: there is no node \"d\"; there are: a, b, c");
  EXPECT_EQ(refusal_of([&] { Names("node").find(use, "no"); }),
            "f.toml:12: use.no: there is no node \"d\"; there are: none");
}

}  // namespace toml_edges_test
}  // namespace spindle_twin::rom::tests
