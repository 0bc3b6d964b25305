// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Exports a symbol from libwaymark_core; all others are hidden.
#if defined(WAYMARK_BUILDING_CORE)
#define WAYMARK_API __attribute__((visibility("default")))
#else
#define WAYMARK_API
#endif

/// Exports the type_info of a type that crosses a shared-library boundary as an exception or by its vtable.
#define WAYMARK_TYPE __attribute__((visibility("default")))
