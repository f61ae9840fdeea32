// `scree view`: options -> a server of pages.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/scene.h>

#include <string>
#include <vector>

namespace scree::command {

struct ViewOptions {
  std::vector<std::string> sources;  // one, or two that are compared
  scenes::Parameters parameters;
  std::string address = "127.0.0.1";
  int port = 7707;
  bool open = false;  // a browser
  std::string save;   // FILE.html instead of a server; empty: none
  int threads = 0;    // 0: one per core
  Isa isa = Isa::automatic;
};

// Serves until a signal ends it. Throws scree::Error for bad options and what cannot be opened.
void view_sources(const ViewOptions& options);

}  // namespace scree::command
