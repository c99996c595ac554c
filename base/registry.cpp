#include "arbox/base/registry.h"

#include <algorithm>
#include <tuple>

#include "arbox/base/error.h"
#include "arbox/base/names.h"

namespace arbox {
namespace {

bool same_name(const RegistryEntry& a, const RegistryEntry& b) {
  return a.kind == b.kind && a.name == b.name;
}

}  // namespace

void Registrar::add_entry(RegistryEntry entry, const std::type_info& factory) {
  const std::string what = entry.kind + " '" + entry.name + "'";
  if (!kind_.empty() && entry.kind != kind_) {
    throw PluginError(origin_ + ": adds the " + what + ", expected entries of its kind '" + kind_ +
                      "'");
  }
  if (*registry_.find_kind(entry.kind).factory != factory) {
    throw PluginError(origin_ + ": adds the " + what + " with a factory of type " + factory.name() +
                      ", expected " + registry_.find_kind(entry.kind).factory->name());
  }
  const RegistryEntry* taken = registry_.lookup(entry.kind, entry.name);
  const auto staged = std::find_if(entries_.begin(), entries_.end(),
                                   [&](const auto& other) { return same_name(other, entry); });
  if (taken != nullptr || staged != entries_.end()) {
    const std::string& other = taken != nullptr ? taken->origin : staged->origin;
    throw PluginError("the " + what + " is registered twice: by " + other + " and by " + origin_);
  }
  entries_.push_back(std::move(entry));
}

void Registry::declare_kind(Kind kind) {
  for (const Kind& known : kinds_) {
    if (known.name != kind.name) continue;
    if (*known.factory == *kind.factory && known.libtorch == kind.libtorch) return;
    throw InvalidArgument("Registry: kind '" + kind.name + "' is already declared differently");
  }
  kinds_.push_back(std::move(kind));
}

void Registry::add_built_in(const std::function<void(Registrar&)>& register_all) {
  Registrar registrar(*this, "built in", "");
  register_all(registrar);
  keep(std::move(registrar.entries_));
}

void Registry::add_plugin(const std::string& file, const std::string& kind, const std::string& name,
                          const std::function<void(Registrar&)>& register_all) {
  Registrar registrar(*this, file, kind);
  register_all(registrar);
  const auto& added = registrar.entries_;
  if (std::none_of(added.begin(), added.end(), [&](const auto& one) { return one.name == name; })) {
    throw PluginError(file + ": does not register the " + kind + " '" + name +
                      "' that it says it is");
  }
  keep(std::move(registrar.entries_));
}

void Registry::keep(std::vector<RegistryEntry> entries) {
  std::move(entries.begin(), entries.end(), std::back_inserter(entries_));
  std::sort(entries_.begin(), entries_.end(), [](const auto& a, const auto& b) {
    return std::tie(a.kind, a.name) < std::tie(b.kind, b.name);
  });
}

std::vector<std::string> Registry::kinds() const {
  std::vector<std::string> names;
  for (const Kind& kind : kinds_) names.push_back(kind.name);
  return names;
}

const Registry::Kind& Registry::find_kind(std::string_view name) const {
  for (const Kind& kind : kinds_) {
    if (kind.name == name) return kind;
  }
  throw PluginError(unknown_name_text("plugin kind", name, kinds()));
}

const std::string& Registry::libtorch_of(std::string_view kind) const {
  return find_kind(kind).libtorch;
}

const RegistryEntry* Registry::lookup(std::string_view kind, std::string_view name) const {
  for (const RegistryEntry& entry : entries_) {
    if (entry.kind == kind && entry.name == name) return &entry;
  }
  return nullptr;
}

bool Registry::contains(std::string_view kind, std::string_view name) const {
  return lookup(kind, name) != nullptr;
}

const RegistryEntry& Registry::find(std::string_view kind, std::string_view name) const {
  return find(kind, name, nullptr);
}

const RegistryEntry& Registry::find(std::string_view kind, std::string_view name,
                                    const OptionsInstance* options) const {
  const RegistryEntry* entry = lookup(kind, name);
  if (entry == nullptr) {
    std::vector<std::string> known;
    for (const RegistryEntry& one : entries_) {
      if (one.kind == kind) known.push_back(one.name);
    }
    throw InvalidArgument(unknown_name_text(kind, name, known));
  }
  if (options != nullptr && options->maker != entry->options) {
    throw InvalidArgument("Registry: the options given to the " + entry->kind + " '" + entry->name +
                          "' are of another struct; make them with its entry's options()");
  }
  return *entry;
}

}  // namespace arbox
