// See page.h. The page's files are in page/; here they become one.
#include <scree/error.h>
#include <tools/export/base64.h>
#include <tools/view/clip.h>
#include <tools/view/page.h>
#include <tools/view/resources.h>

#include <string_view>

namespace scree::view {
namespace {

constexpr std::size_t kMostBytes = 300 << 20;  // strings of browsers end at 512 MiB

void replace(std::string& text, std::string_view mark, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += by.size())
    text.replace(at, mark.size(), by);
}

// Text between tags.
std::string escape(std::string_view text) {
  std::string escaped;
  for (const char letter : text) {
    switch (letter) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += static_cast<unsigned char>(letter) < ' ' ? '?' : letter;
    }
  }
  return escaped;
}

// The page's modules import each other by these names.
template <class Place>
std::string import_map(const Place& place_of) {
  std::string map = "{\"imports\": {";
  for (const Resource& module : modules()) {
    if (&module != modules().data()) map += ",";
    map += "\n\"";
    map += module.name;
    map += "\": \"" + place_of(module) + "\"";
  }
  return map + "}}";
}

std::string fill(const std::string& imports, const std::string& clip, const std::string& title) {
  if (!has_page()) throw Error(kNoPage);
  std::string page(page_text());
  replace(page, "@STYLE@", style_text());
  replace(page, "@IMPORTS@", imports);
  replace(page, "@CLIP@", clip);
  replace(page, "@TITLE@", escape(title));  // the last: a file may be called like a mark
  return page;
}

}  // namespace

std::string make_live_page(const std::string& title) {
  return fill(import_map([](const Resource& module) { return "/module/" + std::string(module.name); }), "",
              title);
}

bool has_page() { return !modules().empty(); }

std::string make_page(const exports::Show& show, const std::string& title) {
  if (!has_page()) throw Error(kNoPage);
  const auto inside = [](const Resource& module) {
    return "data:text/javascript;base64," + exports::base64(module.text);
  };
  std::string page =
      fill(import_map(inside),
           "<script type=\"text/plain\" id=\"clip\">" + exports::base64(make_clip(show, title)) + "</script>",
           title);
  if (page.size() > kMostBytes) {
    throw Error("the page would have " + std::to_string(page.size() >> 20) + " MiB, more than the " +
                std::to_string(kMostBytes >> 20) + " MiB that browsers read; ask for fewer steps");
  }
  return page;
}

}  // namespace scree::view
