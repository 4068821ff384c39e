// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/program.hpp"

int main(int argc, char** argv) {
  return volute::cli::runProgram(argc, argv);
}
