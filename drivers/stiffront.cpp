// SPDX-License-Identifier: BSD-3-Clause
#include "stiffront/app/program.hpp"

int main(int argc, char** argv) { return stiffront::app::run(argc, argv); }
