// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer: an expression is understood, with its derivatives, or refused as input; a reaction equation likewise.
#include "stiffront/model/expression.hpp"

#include <cstdint>
#include <cstdlib>
#include <string>

#include "stiffront/core/error.hpp"

using namespace stiffront;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    ExpressionGraph graph({"u", "v", "t"});
    const ExpressionGraph::Node node = graph.parse(text, {{"k", 2.0}, {"zero", 0.0}});
    for (int v = 0; v < 2; ++v) graph.reachable({node, graph.differentiate(node, v)});
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::input) std::abort();
  }
  return 0;
}
