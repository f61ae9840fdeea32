// See sampled.h.
#include <tools/command/sampled.h>
#include <tools/command/text.h>

namespace scree::command {

std::string table_head(const SampledFigures& figures) {
  std::string table = figures.file + "\n";
  table += row("output", figures.output + ", " + mebibytes(figures.bytes.size()));
  table += row("steps", grouped(figures.from) + " to " + grouped(figures.to));
  return table;
}

std::string table_tail(const SampledFigures& figures) {
  std::string table = row("seconds", format("%.2f", figures.seconds));
  table += row("instruction set", isa_name(figures.isa));
  table += row("threads", std::to_string(figures.threads));
  return table;
}

nlohmann::ordered_json json_head(const SampledFigures& figures) {
  nlohmann::ordered_json json;
  json["file"] = figures.file;
  json["output"] = {{"file", figures.output}, {"bytes", figures.bytes.size()}};
  json["from"] = figures.from;
  json["to"] = figures.to;
  json["samples"] = figures.samples;
  json["bodies"] = figures.bodies;
  return json;
}

std::string finish_json(nlohmann::ordered_json json, const SampledFigures& figures) {
  json["seconds"] = figures.seconds;
  json["isa"] = isa_name(figures.isa);
  json["threads"] = figures.threads;
  // A file's name may hold any bytes.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace scree::command
