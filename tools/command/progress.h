// Progress of a run on standard error: a bar on a terminal, a line every tenth elsewhere.
#pragma once

#include <chrono>
#include <string>

namespace scree::command {

class Progress {
 public:
  Progress(std::string title, int steps, bool enabled);

  void show(int done);  // steps done so far
  void finish();        // clears the bar

 private:
  void draw_bar(int done);

  std::string title_;
  int steps_;
  bool enabled_;
  bool terminal_;
  int tenths_ = 0;  // written so far
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point drawn_;
};

}  // namespace scree::command
