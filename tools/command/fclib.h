// The command `scree fclib`: options, checked, to a file and figures.
#pragma once

#include <tools/fclib/fclib.h>

#include <string>

namespace scree::command {

struct FclibArguments {
  std::string scene;
  scenes::Parameters parameters;
  std::string file;
  int at = 10;
  int threads = 1;
  Isa isa = Isa::automatic;
};

fclib::FclibFigures write_fclib(const FclibArguments& arguments);

}  // namespace scree::command
