#pragma once

#include <memory>
#include <string>

#include "arbox/base/plugin.h"

namespace arbox::testing {

/// A kind for tests: greets people.
class Greeter {
 public:
  virtual ~Greeter() = default;
  virtual std::string greet(const std::string& person) const = 0;
};

struct GreeterOptions {
  std::string word = "Hello";

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("word", &GreeterOptions::word, {.help = "Word of greeting"});
  }
};

struct GreeterKind {
  static constexpr std::string_view kName = "greeter";
  using Factory = std::unique_ptr<Greeter>(const OptionsInstance& options, int repeats);
};

/// A second kind.
struct CounterKind {
  static constexpr std::string_view kName = "counter";
  using Factory = std::unique_ptr<int>(const OptionsInstance& options);
};

class PlainGreeter : public Greeter {
 public:
  PlainGreeter(std::string word, int repeats) : word_(std::move(word)), repeats_(repeats) {}
  std::string greet(const std::string& person) const override {
    std::string text;
    for (int i = 0; i < repeats_; ++i) text += word_ + " ";
    return text + person;
  }

 private:
  std::string word_;
  int repeats_;
};

inline void add_greeter(Registrar& registrar, const std::string& name) {
  registrar.add<GreeterKind, GreeterOptions>(
      name, "Greets", [](const GreeterOptions& options, int repeats) {
        return std::make_unique<PlainGreeter>(options.word, repeats);
      });
}

}  // namespace arbox::testing
