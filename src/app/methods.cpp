// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/methods.hpp"

#include <algorithm>

namespace stiffront::app {

const std::vector<MethodEntry>& methods() {
  static const std::vector<MethodEntry> entries = {
      {"lie", "Lie splitting, order 1, fixed step", "Trotter, Proc. Amer. Math. Soc. 10, 1959", LieOptions{}},
      {"strang", "Strang splitting, order 2, fixed step", "Strang, SIAM J. Numer. Anal. 5(3), 1968", StrangOptions{}},
      {"adaptive-strang", "Strang splitting, step chosen by a shifted embedded splitting and the critical step",
       "Descombes, Duarte, Dumont, Louvet, Massot, Confluentes Math. 3(3), 2011", AdaptiveStrangOptions{}},
      {"dcs", "deferred correction of a splitting on Radau IIA nodes, order up to 2 stages - 1, adaptive or fixed step",
       "Duarte, Emmett, High order schemes based on operator splitting and deferred corrections, hal-01016684, 2016", DcsOptions{}},
      {"sdc", "spectral deferred correction of a preconditioned or IMEX splitting, order up to 2 node_count, adaptive or fixed step",
       "Hagstrom, Zhou, Commun. Appl. Math. Comput. Sci. 1(1), 2006", SdcOptions{}},
      {"sbdf", "IMEX BDF of variable order 2 to 5 with cell-local sweeps, adaptive step",
       "Ascher, Ruuth, Wetton, SIAM J. Numer. Anal. 32(3), 1995; sweeps after Hagstrom, Zhou 2006", SbdfOptions{}},
      {"cvode", "fully coupled variable-order BDF, the reference and a peer",
       "Hindmarsh et al., SUNDIALS, ACM Trans. Math. Softw. 31(3), 2005", CvodeOptions{}},
      {"auto", "one of the above, chosen by a cost model", "cost model of this project", AutoOptions{}},
  };
  return entries;
}

const std::string& method_name(const MethodOptions& options) {
  return std::find_if(methods().begin(), methods().end(),
                      [&options](const MethodEntry& entry) { return entry.defaults.index() == options.index(); })
      ->name;
}

}  // namespace stiffront::app
