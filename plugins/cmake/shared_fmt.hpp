// SPDX-License-Identifier: Apache-2.0
// Included first into every source of an installed library that has fmt as headers (waymark_use_fmt_inside): fmt's
// formatting, half of the compiler's work on a small file, is made in one of its objects, by shared_fmt.cpp.
#pragma once
#include <fmt/format.h>

FMT_BEGIN_NAMESPACE
FMT_BEGIN_DETAIL_NAMESPACE
extern template void vformat_to(buffer<char>& buffer, basic_string_view<char> format,
                                basic_format_args<format_context> arguments, locale_ref locale);
FMT_END_DETAIL_NAMESPACE
FMT_END_NAMESPACE
