#pragma once

#include <memory>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace spindle_twin::bench {

/// Smallest and largest value that is taken.
struct Allowed {
  double from;
  double to;
};

/// The options of a program of tests/bench. CLI11 reads them; its headers cost each source that includes them some
/// seconds of compiler time, and here one does.
class CommandLine {
 public:
  explicit CommandLine(const std::string& what_the_program_is);
  ~CommandLine();

  /// An option with a value: `target` holds the default until parse() is called, and --help shows it. Value is int,
  /// long, unsigned long, double, std::string or std::vector<std::string>, for which the option may be given again.
  /// `allowed` is for numbers.
  template <class Value>
  void add(const char* name, Value& target, const char* what = "", std::optional<Allowed> allowed = {});

  /// An option without a value.
  void add_flag(const char* name, bool& target, const char* what);

  // Of options that were added before.
  void limit(const char* name, Allowed allowed);
  void require(const char* name);
  void exclude(const char* name, const char* other);
  void need(const char* name, const char* other);

  /// Sets the targets. Gives the exit code where the program is to end at once: --help, or an error, which is said.
  [[nodiscard]] std::optional<int> parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace spindle_twin::bench
