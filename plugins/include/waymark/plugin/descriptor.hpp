// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "waymark/config/config.hpp"
#include "waymark/interface/payload_registry.hpp"
#include "waymark/interface/rig.hpp"

/// The binary interface of plugin library and host. A plugin includes the header of its kind instead, which includes
/// this one: waymark/plugin/sensor.hpp, map_module.hpp, source.hpp or sink.hpp.
namespace waymark {

/// Raised whenever an interface of core changes incompatibly.
inline constexpr std::uint32_t kPluginAbi = 16;

#define WAYMARK_STRINGIFY_(x) #x
#define WAYMARK_STRINGIFY(x) WAYMARK_STRINGIFY_(x)

#ifdef _GLIBCXX_DEBUG
#define WAYMARK_GLIBCXX_DEBUG_ 1
#else
#define WAYMARK_GLIBCXX_DEBUG_ 0
#endif

/// Compiler ABI, standard library and Eigen version that C++ objects of this translation unit are laid out for.
inline constexpr const char* kBuildKey =
    "cxxabi=" WAYMARK_STRINGIFY(__GXX_ABI_VERSION) " cxx11=" WAYMARK_STRINGIFY(_GLIBCXX_USE_CXX11_ABI) " debug=" WAYMARK_STRINGIFY(
        WAYMARK_GLIBCXX_DEBUG_) " eigen=" WAYMARK_STRINGIFY(EIGEN_WORLD_VERSION) "." WAYMARK_STRINGIFY(EIGEN_MAJOR_VERSION) "." WAYMARK_STRINGIFY(EIGEN_MINOR_VERSION);

/// A plugin's description of itself, as bytes in the section `.waymark_plugin` of its file: no pointers, so that the
/// host reads and checks it before it loads the library. Append only; `abi` stays first. The texts are as in
/// PluginDescriptor, each filled up with zeros, of which there is at least one.
struct PluginRecord {
  std::uint32_t abi;
  std::uint32_t eigen_max_align;
  char build_key[120];
  char kind[16];
  char name[64];
  char version[32];
};

/// Name of the section of a PluginRecord.
#define WAYMARK_PLUGIN_SECTION ".waymark_plugin"

/// The one symbol that a plugin exports, `waymark_plugin`. Plain C layout, append only; the host compares it with the
/// PluginRecord before it calls `create`.
struct PluginDescriptor {
  std::uint32_t abi;              ///< kPluginAbi
  std::uint32_t eigen_max_align;  ///< EIGEN_MAX_ALIGN_BYTES: differs with -march, and with it the layout of objects
  const char* build_key;          ///< kBuildKey
  const char* kind;               ///< "source", "sensor", "map_module", "sink"
  const char* name;
  const char* version;
  void* (*create)(const Config& config, const Rig& rig);  ///< returns the interface's pointer; may throw Error
  void (*register_payloads)();  ///< makes the plugin's own payloads known; may throw Error; null: it has none
};

/// Copies a text into a field of a PluginRecord; does not compile if it is too long.
template <std::size_t N>
consteval void set_record_text(char (&field)[N], std::string_view text) {
  if (text.size() >= N) throw "WAYMARK_PLUGIN: the name or the version is too long";
  for (std::size_t i = 0; i < text.size(); ++i) field[i] = text[i];
}

/// The record of a plugin that is built with this translation unit's ABI, build key and alignment.
consteval PluginRecord make_plugin_record(std::string_view kind, std::string_view name, std::string_view version) {
  PluginRecord record{kPluginAbi, EIGEN_MAX_ALIGN_BYTES, {}, {}, {}, {}};
  set_record_text(record.build_key, kBuildKey);
  set_record_text(record.kind, kind);
  set_record_text(record.name, name);
  set_record_text(record.version, version);
  return record;
}

class MapModule;
class Sensor;
class Sink;
class Source;

/// Kind of an interface in the descriptor, `PluginKind<Sensor>::kName`. Needs nothing of the interface itself, so that
/// who loads plugins is not compiled again with every interface.
template <class Interface>
struct PluginKind;

template <>
struct PluginKind<MapModule> {
  static constexpr const char* kName = "map_module";
};
template <>
struct PluginKind<Sensor> {
  static constexpr const char* kName = "sensor";
};
template <>
struct PluginKind<Sink> {
  static constexpr const char* kName = "sink";
};
template <>
struct PluginKind<Source> {
  static constexpr const char* kName = "source";
};

template <class Interface>
constexpr const char* plugin_kind() {
  return PluginKind<Interface>::kName;
}

/// Creates a T from its YAML node, with the rig if its constructor takes one.
template <class Interface, class T>
void* create_plugin(const Config& config, const Rig& rig) {
  if constexpr (std::is_constructible_v<T, const Config&, const Rig&>) {
    return static_cast<Interface*>(new T(config, rig));
  } else {
    return static_cast<Interface*>(new T(config));
  }
}

/// Makes the payloads P of a plugin known.
template <class... P>
void register_payloads() {
  (register_payload<P>(), ...);
}

}  // namespace waymark

/// Places a PluginRecord where the host finds it in the file. Nothing refers to it; the attributes make
/// compiler and linker keep it.
#define WAYMARK_PLUGIN_RECORD(record)                   \
  __attribute__((section(WAYMARK_PLUGIN_SECTION), used, \
                 retain)) static constexpr ::waymark::PluginRecord kWaymarkPluginRecord = record;

/// Exports class `Class` as the plugin `name_text` of this library. The plugin's own payloads follow, if it has any, so
/// that sources that read any payload (csv, json, mcap, …) can make them:
///
///     WAYMARK_PLUGIN(waymark::Sensor, BeaconRangeSensor, "beacon_range", "1.0.0", BeaconRange)
#define WAYMARK_PLUGIN(Interface, Class, name_text, version_text, ...)                                               \
  WAYMARK_PLUGIN_RECORD(::waymark::make_plugin_record(::waymark::plugin_kind<Interface>(), name_text, version_text)) \
  extern "C" __attribute__((visibility("default"))) const ::waymark::PluginDescriptor waymark_plugin;                \
  const ::waymark::PluginDescriptor waymark_plugin = {::waymark::kPluginAbi,                                         \
                                                      EIGEN_MAX_ALIGN_BYTES,                                         \
                                                      ::waymark::kBuildKey,                                          \
                                                      ::waymark::plugin_kind<Interface>(),                           \
                                                      name_text,                                                     \
                                                      version_text,                                                  \
                                                      &::waymark::create_plugin<Interface, Class>,                   \
                                                      &::waymark::register_payloads<__VA_ARGS__>};
