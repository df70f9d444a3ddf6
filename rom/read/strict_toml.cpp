#include "rom/read/strict_toml.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <sstream>
#include <utility>

#include "rom/range.hpp"

namespace spindle_twin::rom {

struct TomlTable::State {
  std::shared_ptr<const toml::table> document;  // keeps every table alive
  const toml::table* table = nullptr;
  std::string file;
  std::string parent;  // full name of the enclosing table
  std::string key;     // name of this table in it
  std::string shown;   // index or name behind the key
  std::vector<std::string> asked;
  std::vector<std::shared_ptr<State>> children;

  std::string path() const {
    std::string text = parent;
    if (!key.empty()) text += (text.empty() ? "" : ".") + key;
    return text + shown;
  }

  std::string path(const std::string& of) const {
    const std::string here = path();
    return here.empty() ? of : here + "." + of;
  }

  SourceLine line_of(const toml::source_region& region) const { return {file, static_cast<int>(region.begin.line)}; }

  const toml::node* find(const std::string& wanted) {
    if (std::find(asked.begin(), asked.end(), wanted) == asked.end()) asked.push_back(wanted);
    return table->get(wanted);
  }

  [[noreturn]] void fail_at(const toml::node& node, const std::string& of, const std::string& message) const {
    throw InputError(line_of(node.source()), path(of), message);
  }

  const toml::node& require(const std::string& wanted);
  std::shared_ptr<State> child(const toml::table& of, const std::string& name, const std::string& index) {
    auto made = std::make_shared<State>(State{document, &of, file, path(), name, index, {}, {}});
    children.push_back(made);
    return made;
  }
};

namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

/// The candidate nearest to `word` if it is near enough to be a slip of the pen, else empty.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const auto& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

/// The number in `node`, or a text saying what is wrong with it.
double checked_number(const toml::node& node, Range range, std::string& complaint) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value) {
    complaint = "must be " + allowed(range) + ", is " + type_name(node);
    return 0.0;
  }
  if (!is_allowed(range, *value)) complaint = "must be " + allowed(range) + ", is " + printed(*value);
  return *value;
}

}  // namespace

const toml::node& TomlTable::State::require(const std::string& wanted) {
  const toml::node* node = find(wanted);
  if (node == nullptr) {
    std::vector<std::string> unread;
    for (const auto& [present, value] : *table) {
      const std::string word(present.str());
      if (std::find(asked.begin(), asked.end(), word) == asked.end()) unread.push_back(word);
    }
    const std::string slip = nearest(wanted, unread);
    const SourceLine line = slip.empty() ? line_of(table->source()) : line_of(table->find(slip)->first.source());
    throw InputError(line, path(wanted),
                     "this key is required" + (slip.empty() ? "" : " (is \"" + slip + "\" meant to be it?)"));
  }
  return *node;
}

TomlTable TomlTable::read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  if (!stream || !text) throw InputError({path, 0}, "", "cannot be read as a file");
  return parse(text.str(), path);
}

TomlTable TomlTable::parse(const std::string& text, const std::string& file) {
  try {
    auto document = std::make_shared<const toml::table>(toml::parse(text, file));
    return TomlTable(std::make_shared<State>(State{document, document.get(), file, "", "", "", {}, {}}));
  } catch (const toml::parse_error& error) {
    throw InputError({file, static_cast<int>(error.source().begin.line)}, "",
                     "not valid TOML: " + std::string(error.description()));
  }
}

bool TomlTable::has(const std::string& key) const { return state_->find(key) != nullptr; }

bool TomlTable::is_table(const std::string& key) const { return has(key) && state_->find(key)->is_table(); }

double TomlTable::number(const std::string& key, Range range) const {
  const toml::node& node = state_->require(key);
  std::string complaint;
  const double value = checked_number(node, range, complaint);
  if (!complaint.empty()) state_->fail_at(node, key, complaint);
  return value;
}

double TomlTable::number_or(const std::string& key, double otherwise, Range range) const {
  return has(key) ? number(key, range) : otherwise;
}

std::optional<double> TomlTable::optional_number(const std::string& key, Range range) const {
  if (!has(key)) return std::nullopt;
  return number(key, range);
}

std::int64_t TomlTable::integer(const std::string& key, std::int64_t min, std::int64_t max) const {
  const toml::node& node = state_->require(key);
  const std::string wanted = "must be an integer from " + std::to_string(min) + " to " + std::to_string(max) + ", is ";
  if (!node.is_integer()) state_->fail_at(node, key, wanted + type_name(node));
  const std::int64_t value = node.as_integer()->get();
  if (value < min || value > max) state_->fail_at(node, key, wanted + std::to_string(value));
  return value;
}

std::int64_t TomlTable::integer_or(const std::string& key, std::int64_t otherwise, std::int64_t min,
                                   std::int64_t max) const {
  return has(key) ? integer(key, min, max) : otherwise;
}

bool TomlTable::boolean(const std::string& key) const {
  const toml::node& node = state_->require(key);
  if (!node.is_boolean()) state_->fail_at(node, key, "must be true or false, is " + type_name(node));
  return node.as_boolean()->get();
}

bool TomlTable::boolean_or(const std::string& key, bool otherwise) const { return has(key) ? boolean(key) : otherwise; }

std::string TomlTable::string(const std::string& key) const {
  const toml::node& node = state_->require(key);
  if (!node.is_string()) state_->fail_at(node, key, "must be a string, is " + type_name(node));
  return node.as_string()->get();
}

std::string TomlTable::string_or(const std::string& key, const std::string& otherwise) const {
  return has(key) ? string(key) : otherwise;
}

std::optional<std::string> TomlTable::optional_string(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return string(key);
}

std::string TomlTable::choice(const std::string& key, const std::vector<std::string>& words) const {
  std::string value = string(key);
  if (std::find(words.begin(), words.end(), value) == words.end()) {
    fail(key, "must be one of " + joined(words) + ", is \"" + value + "\"");
  }
  return value;
}

std::string TomlTable::choice_or(const std::string& key, const std::string& otherwise,
                                 const std::vector<std::string>& words) const {
  return has(key) ? choice(key, words) : otherwise;
}

std::string TomlTable::name(const std::string& key) const {
  std::string value = string(key);
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto inside = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (value.empty() || !letter(value.front()) || !std::all_of(value.begin(), value.end(), inside)) {
    fail(key, "must be letters, digits and underscores and start with a letter, is \"" + value + "\"");
  }
  return value;
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t count, Range range) const {
  const toml::node& node = state_->require(key);
  const toml::array* array = node.as_array();
  if (array == nullptr || (count != 0 && array->size() != count)) {
    state_->fail_at(node, key,
                    "must be an array of " + (count == 0 ? std::string() : std::to_string(count) + " ") +
                        "numbers, is " +
                        (array == nullptr ? type_name(node) : "an array of " + std::to_string(array->size())));
  }
  std::vector<double> values;
  for (const toml::node& entry : *array) {
    std::string complaint;
    values.push_back(checked_number(entry, range, complaint));
    if (!complaint.empty()) state_->fail_at(entry, key, "every entry " + complaint);
  }
  return values;
}

std::vector<std::vector<double>> TomlTable::rows_or_empty(const std::string& key, std::size_t columns,
                                                          Range range) const {
  std::vector<std::vector<double>> rows;
  const toml::node* node = state_->find(key);
  if (node == nullptr) return rows;
  const std::string wanted = "must be an array of arrays of " + std::to_string(columns) + " numbers each";
  if (!node->is_array()) state_->fail_at(*node, key, wanted + ", is " + type_name(*node));
  for (const toml::node& entry : *node->as_array()) {
    const toml::array* inner = entry.as_array();
    if (inner == nullptr || inner->size() != columns) state_->fail_at(entry, key, wanted);
    std::vector<double> row;
    for (const toml::node& value : *inner) {
      std::string complaint;
      row.push_back(checked_number(value, range, complaint));
      if (!complaint.empty()) state_->fail_at(value, key, "every entry " + complaint);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::string> TomlTable::strings(const std::string& key) const {
  const toml::node& node = state_->require(key);
  if (!node.is_array()) state_->fail_at(node, key, "must be an array of strings, is " + type_name(node));
  std::vector<std::string> values;
  for (const toml::node& entry : *node.as_array()) {
    if (!entry.is_string()) state_->fail_at(entry, key, "every entry must be a string, is " + type_name(entry));
    values.push_back(entry.as_string()->get());
  }
  return values;
}

std::vector<std::string> TomlTable::strings_or_empty(const std::string& key) const {
  return has(key) ? strings(key) : std::vector<std::string>{};
}

TomlTable TomlTable::table(const std::string& key) const {
  const toml::node& node = state_->require(key);
  if (!node.is_table()) state_->fail_at(node, key, "must be a table, is " + type_name(node));
  return TomlTable(state_->child(*node.as_table(), key, ""));
}

std::optional<TomlTable> TomlTable::optional_table(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return table(key);
}

std::vector<TomlTable> TomlTable::tables_or_empty(const std::string& key) const {
  std::vector<TomlTable> found;
  const toml::node* node = state_->find(key);
  if (node == nullptr) return found;
  if (!node->is_array()) state_->fail_at(*node, key, "must be an array of tables, is " + type_name(*node));
  for (const toml::node& entry : *node->as_array()) {
    if (!entry.is_table()) state_->fail_at(entry, key, "every entry must be a table, is " + type_name(entry));
    std::string index = "[";
    index += std::to_string(found.size() + 1) + "]";
    found.push_back(TomlTable(state_->child(*entry.as_table(), key, index)));
  }
  return found;
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) const {
  state_->require(key);
  auto found = tables_or_empty(key);
  if (found.empty()) fail(key, "must hold at least one table");
  return found;
}

std::vector<std::string> TomlTable::free_keys() const {
  std::vector<std::pair<toml::source_position, std::string>> keys;
  for (const auto& [key, value] : *state_->table) keys.emplace_back(key.source().begin, std::string(key.str()));
  std::sort(keys.begin(), keys.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [position, name] : keys) {
    state_->find(name);
    names.push_back(std::move(name));
  }
  return names;
}

SourceLine TomlTable::where() const { return state_->line_of(state_->table->source()); }

SourceLine TomlTable::where(const std::string& key) const {
  const auto found = state_->table->find(key);
  return found == state_->table->end() ? where() : state_->line_of(found->first.source());
}

std::string TomlTable::path(const std::string& key) const { return state_->path(key); }

void TomlTable::show_as(const std::string& name) const { state_->shown = "." + name; }

void TomlTable::fail(const std::string& key, const std::string& message) const {
  throw InputError(where(key), path(key), message);
}

void TomlTable::finish() const {
  struct Stranger {
    toml::source_position at;
    const State* state = nullptr;
    std::string key;
  };
  std::optional<Stranger> first;
  const auto search = [&first](const State& state, const auto& again) -> void {
    for (const auto& [key, value] : *state.table) {
      const std::string word(key.str());
      if (std::find(state.asked.begin(), state.asked.end(), word) != state.asked.end()) continue;
      if (!first || key.source().begin < first->at) first = Stranger{key.source().begin, &state, word};
    }
    for (const auto& child : state.children) again(*child, again);
  };
  search(*state_, search);
  if (!first) return;
  const State& state = *first->state;
  const std::string slip = nearest(first->key, state.asked);
  throw InputError({state.file, static_cast<int>(first->at.line)}, state.path(first->key),
                   "unknown key" + (slip.empty() ? "" : ", did you mean \"" + slip + "\"?") +
                       "; allowed here: " + joined(state.asked));
}

}  // namespace spindle_twin::rom
