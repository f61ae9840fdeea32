// The figures of a run, as a table for people and as JSON for programs.
#pragma once

#include <tools/command/run.h>

#include <string>

namespace scree::command {

std::string to_table(const RunFigures& figures);
std::string to_json(const RunFigures& figures);

}  // namespace scree::command
