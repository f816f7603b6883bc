// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <fmt/format.h>

#include "stiffront/core/error.hpp"

namespace stiffront {

/// f.template operator()<n>() for a number of species known at run time, 1 to 8.
template <class Result, class F>
Result for_species_count(int n, F&& f) {
  switch (n) {
    case 1:
      return f.template operator()<1>();
    case 2:
      return f.template operator()<2>();
    case 3:
      return f.template operator()<3>();
    case 4:
      return f.template operator()<4>();
    case 5:
      return f.template operator()<5>();
    case 6:
      return f.template operator()<6>();
    case 7:
      return f.template operator()<7>();
    case 8:
      return f.template operator()<8>();
    default:
      throw Error(ErrorKind::input, fmt::format("an implicit solver for {} species is not available; 8 is the most", n));
  }
}

}  // namespace stiffront
