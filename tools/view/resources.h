// The files of the page, which the build puts into the program; none where it has no page.
#pragma once

#include <span>
#include <string_view>

namespace scree::view {

struct Resource {
  std::string_view name;  // by which modules import it
  std::string_view text;
};

std::string_view page_text();
std::string_view style_text();
std::span<const Resource> modules();

}  // namespace scree::view
