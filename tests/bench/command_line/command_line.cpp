#include "tests/bench/command_line/command_line.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <type_traits>
#include <vector>

namespace spindle_twin::bench {

CommandLine::CommandLine(const std::string& what_the_program_is)
    : app_(std::make_unique<CLI::App>(what_the_program_is)) {}

CommandLine::~CommandLine() = default;

template <class Value>
void CommandLine::add(const char* name, Value& target, const char* what, std::optional<Allowed> allowed) {
  CLI::Option* const option = app_->add_option(name, target, what);
  if constexpr (std::is_arithmetic_v<Value>) {
    option->capture_default_str();
    if (allowed) option->check(CLI::Range(static_cast<Value>(allowed->from), static_cast<Value>(allowed->to)));
  }
  if constexpr (std::is_same_v<Value, std::string>) option->capture_default_str();
}

template void CommandLine::add(const char*, int&, const char*, std::optional<Allowed>);
template void CommandLine::add(const char*, long&, const char*, std::optional<Allowed>);
template void CommandLine::add(const char*, unsigned long&, const char*, std::optional<Allowed>);
template void CommandLine::add(const char*, double&, const char*, std::optional<Allowed>);
template void CommandLine::add(const char*, std::string&, const char*, std::optional<Allowed>);
template void CommandLine::add(const char*, std::vector<std::string>&, const char*, std::optional<Allowed>);

void CommandLine::add_flag(const char* name, bool& target, const char* what) { app_->add_flag(name, target, what); }

void CommandLine::limit(const char* name, Allowed allowed) {
  app_->get_option(name)->check(CLI::Range(allowed.from, allowed.to));
}

void CommandLine::require(const char* name) { app_->get_option(name)->required(); }

void CommandLine::exclude(const char* name, const char* other) {
  app_->get_option(name)->excludes(app_->get_option(other));
}

void CommandLine::need(const char* name, const char* other) { app_->get_option(name)->needs(app_->get_option(other)); }

std::optional<int> CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app_->exit(error);
  }
  return {};
}

}  // namespace spindle_twin::bench
