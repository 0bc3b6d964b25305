// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Marks what libwaymark_core exports; everything else is hidden.
#if defined(WAYMARK_BUILDING_CORE)
#define WAYMARK_API __attribute__((visibility("default")))
#else
#define WAYMARK_API
#endif

/// Types that cross a shared-library border by exception or by vtable need a visible type_info on both sides.
#define WAYMARK_TYPE __attribute__((visibility("default")))
