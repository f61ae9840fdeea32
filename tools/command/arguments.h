// The command line: values as they are written there, and what CLI11 must know to read them.
#pragma once

#include <tools/command/accuracy.h>
#include <tools/command/compare.h>
#include <tools/command/decompose.h>
#include <tools/command/export.h>
#include <tools/command/extract.h>
#include <tools/command/fclib.h>
#include <tools/command/render.h>
#include <tools/command/replay.h>
#include <tools/command/run.h>
#include <tools/command/shape_files.h>
#include <tools/command/view.h>
#include <tools/files/output_file.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace scree::command {

// Values of the command line, as text; checked when the run begins.
struct Arguments {
  bool json_to_standard_output() const {
    return json == "-" || files::is_standard_stream(json, STDOUT_FILENO);
  }

  RunOptions options;
  ReplayOptions replay;
  DiffOptions diff;
  AccuracyArguments accuracy;
  CompareArguments compare;
  FclibArguments fclib;
  DecomposeArguments decompose;
  HullArguments hull;
  MassArguments mass;
  RenderOptions render;
  ExtractOptions extract;
  ExportOptions exported;
  ViewOptions view;
  std::string info_file;
  std::vector<std::string> settings;
  std::string isa = "auto";
  std::string json;  // empty: none
};

// The options of each command.
void declare_render(CLI::App& app, Arguments& arguments);
void declare_extract(CLI::App& app, Arguments& arguments);
void declare_run(CLI::App& app, Arguments& arguments);
void declare_replay(CLI::App& app, Arguments& arguments);
void declare_info(CLI::App& app, Arguments& arguments);
void declare_diff(CLI::App& app, Arguments& arguments);
void declare_compare(CLI::App& app, Arguments& arguments);
void declare_fclib(CLI::App& app, Arguments& arguments);
void declare_hull(CLI::App& app, Arguments& arguments);
void declare_decompose(CLI::App& app, Arguments& arguments);
void declare_mass(CLI::App& app, Arguments& arguments);
void declare_export(CLI::App& app, Arguments& arguments);
void declare_view(CLI::App& app, Arguments& arguments);

}  // namespace scree::command
