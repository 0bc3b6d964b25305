// SPDX-License-Identifier: Apache-2.0
#include "shared_fmt.hpp"

template void fmt::detail::vformat_to(fmt::detail::buffer<char>& buffer, fmt::basic_string_view<char> format,
                                      fmt::basic_format_args<fmt::format_context> arguments,
                                      fmt::detail::locale_ref locale);
