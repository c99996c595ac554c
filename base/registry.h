#pragma once

#include <any>
#include <functional>
#include <string>
#include <string_view>
#include <typeinfo>
#include <utility>
#include <vector>

#include "arbox/base/options.h"

/// \file
/// What can be chosen by name: detectors, heads and whatever other kinds of things a room declares.
///
/// A kind is a struct in the room that owns the interface:
///
///     struct DetectorKind {
///       static constexpr std::string_view kName = "detector";
///       using Factory = std::unique_ptr<Detector>(const OptionsInstance& options);
///     };
///
/// Its factory takes the options first, then whatever the kind needs. Built-ins and plugins
/// register through the same Registrar.

namespace arbox {

class Registry;

/// One thing that can be chosen by name.
struct RegistryEntry {
  std::string kind;
  std::string name;
  std::string help;
  /// "built in", or the file of the plugin.
  std::string origin;
  OptionsMaker options = nullptr;
  /// A std::function of the kind's factory type.
  std::any factory;
};

/// Receives the entries of one room or plugin. They become known together when all are added.
class Registrar {
 public:
  /// Adds `name` to a kind; `make` takes `const Options&` and the kind's further arguments.
  /// Throws PluginError for an undeclared kind, a plugin's entry of another kind than it says, and
  /// a name that is taken (naming both files).
  template <class Kind, class Options, class Make>
  void add(std::string name, std::string help, Make make) {
    std::function<typename Kind::Factory> factory =
        [make = std::move(make)](const OptionsInstance& options, auto&&... rest) {
          return make(*static_cast<const Options*>(options.storage.get()),
                      std::forward<decltype(rest)>(rest)...);
        };
    add_entry({std::string(Kind::kName), std::move(name), std::move(help), origin_,
               &make_options<Options>, std::move(factory)},
              typeid(typename Kind::Factory));
  }

 private:
  friend class Registry;
  Registrar(const Registry& registry, std::string origin, std::string kind)
      : registry_(registry), origin_(std::move(origin)), kind_(std::move(kind)) {}
  void add_entry(RegistryEntry entry, const std::type_info& factory);

  const Registry& registry_;
  std::string origin_;
  // The only kind that may be added; empty for any.
  std::string kind_;
  std::vector<RegistryEntry> entries_;
};

/// The kinds and names that a program knows. A const Registry may be used from several threads.
class Registry {
 public:
  /// Makes a kind known. `libtorch` is LibTorch's version for kinds that pass tensors: plugins of
  /// the kind must be built against it.
  template <class Kind>
  void declare(std::string libtorch = "") {
    declare_kind({std::string(Kind::kName), &typeid(typename Kind::Factory), std::move(libtorch)});
  }

  /// Calls `register_all` and keeps what it adds; nothing if it throws.
  void add_built_in(const std::function<void(Registrar&)>& register_all);

  /// The same for a plugin, which must add `name` of `kind` and may add more of that kind.
  void add_plugin(const std::string& file, const std::string& kind, const std::string& name,
                  const std::function<void(Registrar&)>& register_all);

  /// Calls the factory of a name. Throws InvalidArgument that lists the known names and the nearest
  /// for an unknown one, and for options of another struct.
  template <class Kind, class... Arguments>
  auto create(std::string_view name, const OptionsInstance& options,
              Arguments&&... arguments) const {
    const auto* factory = std::any_cast<std::function<typename Kind::Factory>>(
        &find(Kind::kName, name, &options).factory);
    return (*factory)(options, std::forward<Arguments>(arguments)...);
  }

  /// Throws InvalidArgument as create does.
  const RegistryEntry& find(std::string_view kind, std::string_view name) const;
  bool contains(std::string_view kind, std::string_view name) const;
  /// All entries, sorted by kind and name.
  const std::vector<RegistryEntry>& entries() const { return entries_; }
  std::vector<std::string> kinds() const;
  /// LibTorch's version that a kind needs. Throws PluginError for an undeclared kind.
  const std::string& libtorch_of(std::string_view kind) const;

 private:
  friend class Registrar;
  struct Kind {
    std::string name;
    const std::type_info* factory;
    std::string libtorch;
  };

  void declare_kind(Kind kind);
  const Kind& find_kind(std::string_view name) const;
  const RegistryEntry* lookup(std::string_view kind, std::string_view name) const;
  const RegistryEntry& find(std::string_view kind, std::string_view name,
                            const OptionsInstance* options) const;
  void keep(std::vector<RegistryEntry> entries);

  std::vector<Kind> kinds_;
  std::vector<RegistryEntry> entries_;
};

}  // namespace arbox
