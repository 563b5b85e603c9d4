#pragma once

#include "app/commands/command.h"

namespace pliant {

/// Adds what makes tables of many results to `evaluate`: compare, study, calibration, self-test.
void add_evaluate_tables(CLI::App& evaluate, Program& program);

}  // namespace pliant
