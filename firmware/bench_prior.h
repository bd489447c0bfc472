// Fitting the least-squares weights' prior to photographs.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

namespace cupola {

// Half the mean square difference of pixels so far apart, along rows and columns, as a share of that of
// neighbours. Pairs with a black pixel, which cut-out panoramas have, are left out.
struct Unlikeness {
  int distance = 0;  // pixels
  double measured = 0.0;
  double fitted = 0.0;
};
struct PriorFit {
  double exponent = 0.0;  // the power law's, whose means over square pixels come nearest; logarithms compared
  std::vector<Unlikeness> distances;
};

// Pictures with equal say, whatever their contrast.
PriorFit fit_prior(const std::vector<std::filesystem::path>& photographs);

}  // namespace cupola
