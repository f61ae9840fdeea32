// `scree export`: a recording -> a show -> a file for viewers of others.
#pragma once

#include <tools/command/sampled.h>

#include <string>

namespace scree::command {

using ExportOptions = SampledOptions;  // the output is .html, .gltf, .glb or .mcap

struct ExportFigures : SampledFigures {
  double duration = 0.0;  // s, of the show
};

// Throws scree::Error for bad options and for files that are no recordings.
ExportFigures export_show(const ExportOptions& options);

std::string to_table(const ExportFigures& figures);
std::string to_json(const ExportFigures& figures);

}  // namespace scree::command
