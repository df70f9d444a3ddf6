#include "rom/read/options.hpp"

#include "rom/range.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {
namespace {

constexpr const char* zero_or_least = "must be 0 or at least 1e-9";

bool is_between(const Option& option, double value) { return option.or_zero && value > 0.0 && value < least_but_zero; }

}  // namespace

Range ReadOptions::range_of(const Option& option) const {
  const auto found = narrowed_.find(std::string(option.key));
  return found == narrowed_.end() ? option.range : found->second;
}

void ReadOptions::operator()(const Option& option, double& value) const {
  const std::string key(option.key);
  if (!table_.has(key)) return;
  const double written = table_.number(key, range_of(option));
  if (is_between(option, written)) table_.fail(key, zero_or_least);
  value = option.written_as_0 + written;
}

void ReadOptions::operator()(const Option& option, int& value) const {
  const Range range = range_of(option);
  value = static_cast<int>(table_.integer_or(std::string(option.key), value, static_cast<std::int64_t>(range.min),
                                             static_cast<std::int64_t>(range.max)));
}

void ReadOptions::operator()(const Option& option, bool& value) const {
  value = table_.boolean_or(std::string(option.key), value);
}

void CheckOptions::operator()(const Option& option, double value) const {
  const double written = value - option.written_as_0;
  const std::string field = prefix_ + std::string(option.key);
  if (!is_allowed(option.range, written)) throw InputError({}, field, "must be " + allowed(option.range));
  if (is_between(option, written)) throw InputError({}, field, zero_or_least);
}

}  // namespace spindle_twin::rom
