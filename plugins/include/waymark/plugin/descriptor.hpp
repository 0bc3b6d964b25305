// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <type_traits>

#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"

/// The binary interface of plugin library and host. A plugin includes the header of its kind instead, which includes
/// this one: waymark/plugin/sensor.hpp, map_module.hpp, source.hpp or sink.hpp.
namespace waymark {

/// Raised whenever an interface of core changes incompatibly.
inline constexpr std::uint32_t kPluginAbi = 9;

#define WAYMARK_STRINGIFY_(x) #x
#define WAYMARK_STRINGIFY(x) WAYMARK_STRINGIFY_(x)

/// Compiler ABI and Eigen version that C++ objects of this translation unit are laid out for.
inline constexpr const char* kBuildKey =
    "cxxabi=" WAYMARK_STRINGIFY(__GXX_ABI_VERSION) " cxx11=" WAYMARK_STRINGIFY(_GLIBCXX_USE_CXX11_ABI) " eigen=" WAYMARK_STRINGIFY(
        EIGEN_WORLD_VERSION) "." WAYMARK_STRINGIFY(EIGEN_MAJOR_VERSION) "." WAYMARK_STRINGIFY(EIGEN_MINOR_VERSION);

/// The one symbol that a plugin exports, `waymark_plugin`. Plain C layout, append only; the host checks it before it
/// calls any C++.
struct PluginDescriptor {
  std::uint32_t abi;              ///< kPluginAbi
  std::uint32_t eigen_max_align;  ///< EIGEN_MAX_ALIGN_BYTES: differs with -march, and with it the layout of objects
  const char* build_key;          ///< kBuildKey
  const char* kind;               ///< "source", "sensor", "map_module", "sink"
  const char* name;
  const char* version;
  void* (*create)(const Config& config, const Rig& rig);  ///< returns the interface's pointer; may throw Error
};

/// Kind of an interface in the descriptor, `PluginKind<Sensor>::kName`. Defined in the header of each kind.
template <class Interface>
struct PluginKind;

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

}  // namespace waymark

/// Exports class `Class` as the plugin `name_text` of this library.
#define WAYMARK_PLUGIN(Interface, Class, name_text, version_text)                                     \
  extern "C" __attribute__((visibility("default"))) const ::waymark::PluginDescriptor waymark_plugin; \
  const ::waymark::PluginDescriptor waymark_plugin = {::waymark::kPluginAbi,                          \
                                                      EIGEN_MAX_ALIGN_BYTES,                          \
                                                      ::waymark::kBuildKey,                           \
                                                      ::waymark::plugin_kind<Interface>(),            \
                                                      name_text,                                      \
                                                      version_text,                                   \
                                                      &::waymark::create_plugin<Interface, Class>};
