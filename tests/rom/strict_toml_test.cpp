#include "rom/read/strict_toml.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace spindle_twin::rom {
namespace strict_toml_test {

std::string message_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

TomlTable parse(const std::string& text) { return TomlTable::parse(text, "f.toml"); }

TEST(StrictToml, typed_values_come_through) {
  const auto root = parse(
      "a = 1\nb = 2.5\nc = \"word\"\nd = true\ne = [1, 2.5]\nf = [[1, 2], [3, 4]]\ng = [\"x\", \"y\"]\n"
      "[h]\ni = -3\n[[j]]\nname = \"first\"\n[[j]]\nname = \"second\"\n");
  EXPECT_EQ(root.number("a"), 1.0);
  EXPECT_EQ(root.number("b", positive), 2.5);
  EXPECT_EQ(root.string("c"), "word");
  EXPECT_TRUE(root.boolean("d"));
  EXPECT_EQ(root.numbers("e", 2), (std::vector<double>{1.0, 2.5}));
  EXPECT_EQ(root.rows_or_empty("f", 2), (std::vector<std::vector<double>>{{1, 2}, {3, 4}}));
  EXPECT_EQ(root.strings("g"), (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(root.table("h").integer("i", -5, 5), -3);
  const auto tables = root.tables("j");
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0].name(), "first");
  EXPECT_EQ(tables[1].name(), "second");
  EXPECT_EQ(tables[1].where("name").line, 13);
  EXPECT_EQ(root.number_or("missing", 7.0), 7.0);
  EXPECT_FALSE(root.optional_number("missing").has_value());
  EXPECT_NO_THROW(root.finish());
}

TEST(StrictToml, unknown_key_names_line_suggestion_and_what_is_allowed) {
  const auto root = parse("[daemon]\nport = 1502\nperiod = 1.0\n");
  const auto daemon = root.table("daemon");
  EXPECT_EQ(daemon.integer("port", 1, 65535), 1502);
  daemon.number_or("period_s", 1.0);
  EXPECT_EQ(message_of([&] { root.finish(); }),
            "f.toml:3: daemon.period: unknown key, did you mean \"period_s\"?; allowed here: port, period_s");
}

TEST(StrictToml, first_unknown_key_by_line_is_the_one_reported) {
  const auto root = parse("[b]\nx = 1\n[a]\ny = 2\n");
  root.table("b");
  root.table("a");
  EXPECT_EQ(message_of([&] { root.finish(); }).substr(0, 12), "f.toml:2: b.");
}

TEST(StrictToml, missing_key_points_to_a_misspelt_one) {
  const auto root = parse("[[part]]\nname = \"shaft\"\nmatrial = \"steel\"\n");
  const auto part = root.tables("part").front();
  part.show_as(part.name());
  EXPECT_EQ(message_of([&] { part.string("material"); }),
            "f.toml:3: part.shaft.material: this key is required (is \"matrial\" meant to be it?)");
  EXPECT_EQ(message_of([&] { part.number("size"); }), "f.toml:1: part.shaft.size: this key is required");
}

TEST(StrictToml, range_and_finiteness_are_checked) {
  const auto root = parse("a = -1\nb = nan\nc = inf\nd = 0\ne = [1, -inf]\nf = 70000\n");
  EXPECT_EQ(message_of([&] { root.number("a", not_negative); }), "f.toml:1: a: must be a number of at least 0, is -1");
  EXPECT_EQ(message_of([&] { root.number("b"); }), "f.toml:2: b: must be a finite number, is nan");
  EXPECT_EQ(message_of([&] { root.number("c"); }), "f.toml:3: c: must be a finite number, is inf");
  EXPECT_EQ(message_of([&] { root.number("d", positive); }), "f.toml:4: d: must be a number above 0, is 0");
  EXPECT_EQ(message_of([&] { root.number("a", between(0, 1)); }), "f.toml:1: a: must be a number from 0 to 1, is -1");
  EXPECT_EQ(message_of([&] { root.numbers("e"); }), "f.toml:5: e: every entry must be a finite number, is -inf");
  EXPECT_EQ(message_of([&] { root.integer("f", 1, 65535); }),
            "f.toml:6: f: must be an integer from 1 to 65535, is 70000");
}

TEST(StrictToml, wrong_type_names_both_types) {
  const auto root = parse("a = \"1\"\nb = 1.5\nc = 3\nd = [1, 2, 3]\n[e]\n");
  EXPECT_EQ(message_of([&] { root.number("a"); }), "f.toml:1: a: must be a finite number, is a string");
  EXPECT_EQ(message_of([&] { root.integer("b", 0, 9); }), "f.toml:2: b: must be an integer from 0 to 9, is a number");
  EXPECT_EQ(message_of([&] { root.string("c"); }), "f.toml:3: c: must be a string, is an integer");
  EXPECT_EQ(message_of([&] { root.boolean("c"); }), "f.toml:3: c: must be true or false, is an integer");
  EXPECT_EQ(message_of([&] { root.numbers("d", 2); }), "f.toml:4: d: must be an array of 2 numbers, is an array of 3");
  EXPECT_EQ(message_of([&] { root.tables("e"); }), "f.toml:5: e: must be an array of tables, is a table");
}

TEST(StrictToml, rows_are_arrays_of_as_many_numbers_as_there_are_columns) {
  const auto root = parse("a = [[1, 2], [3, 4]]\nb = [[1, 2], 3]\nc = [[1, 2],\n[3]]\nd = 5\ne = [[1, \"2\"]]\n");
  EXPECT_EQ(root.rows_or_empty("a", 2), (std::vector<std::vector<double>>{{1, 2}, {3, 4}}));
  EXPECT_EQ(root.rows_or_empty("none", 2), std::vector<std::vector<double>>());
  const std::string wanted = "must be an array of arrays of 2 numbers each";
  EXPECT_EQ(message_of([&] { root.rows_or_empty("b", 2); }), "f.toml:2: b: " + wanted);
  EXPECT_EQ(message_of([&] { root.rows_or_empty("c", 2); }), "f.toml:4: c: " + wanted);
  EXPECT_EQ(message_of([&] { root.rows_or_empty("d", 2); }), "f.toml:5: d: " + wanted + ", is an integer");
  EXPECT_EQ(message_of([&] { root.rows_or_empty("e", 2); }),
            "f.toml:6: e: every entry must be a finite number, is a string");
}

TEST(StrictToml, choice_lists_the_words) {
  const auto root = parse("mode = \"fast\"\n");
  EXPECT_EQ(message_of([&] {
              root.choice("mode", {"paper", "off"});
            }),
            "f.toml:1: mode: must be one of paper, off, is \"fast\"");
}

TEST(StrictToml, syntax_error_has_file_and_line) {
  const std::string message = message_of([] { parse("a = 1\nb = = 2\n"); });
  EXPECT_EQ(message.substr(0, 28), "f.toml:2: not valid TOML: Er") << message;
  const std::string doubled = message_of([] { parse("a = 1\na = 2\n"); });
  EXPECT_EQ(doubled.substr(0, 26), "f.toml:2: not valid TOML: ") << doubled;
}

TEST(StrictToml, unreadable_file_is_an_input_error) {
  EXPECT_EQ(message_of([] { TomlTable::read("/nowhere/x.toml"); }), "/nowhere/x.toml: cannot be read as a file");
}

}  // namespace strict_toml_test
}  // namespace spindle_twin::rom
