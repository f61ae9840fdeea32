// See resources.h. The assembler includes the files as they are; the build names their folders.
#include <tools/view/resources.h>

#include <array>

// Two symbols around the bytes of a file.
#define SCREE_INCLUDE_FILE(symbol, path)                                                        \
  __asm__(                                                                                      \
      ".section .rodata\n"                                                                      \
      ".globl scree_view_" #symbol "_begin\nscree_view_" #symbol                                \
      "_begin:\n"                                                                               \
      ".incbin \"" path                                                                         \
      "\"\n"                                                                                    \
      ".globl scree_view_" #symbol "_end\nscree_view_" #symbol                                  \
      "_end:\n"                                                                                 \
      ".byte 0\n.previous\n");                                                                  \
  extern "C" {                                                                                  \
  extern const char scree_view_##symbol##_begin[], scree_view_##symbol##_end[];                 \
  }                                                                                             \
  static std::string_view symbol() {                                                            \
    return {scree_view_##symbol##_begin,                                                        \
            static_cast<std::size_t>(scree_view_##symbol##_end - scree_view_##symbol##_begin)}; \
  }

SCREE_INCLUDE_FILE(file_page, SCREE_VIEW_PAGE "/index.html")
SCREE_INCLUDE_FILE(file_style, SCREE_VIEW_PAGE "/style.css")
SCREE_INCLUDE_FILE(file_clip, SCREE_VIEW_PAGE "/clip.js")
SCREE_INCLUDE_FILE(file_colors, SCREE_VIEW_PAGE "/colors.js")
SCREE_INCLUDE_FILE(file_compare, SCREE_VIEW_PAGE "/compare.js")
SCREE_INCLUDE_FILE(file_controls, SCREE_VIEW_PAGE "/controls.js")
SCREE_INCLUDE_FILE(file_detail, SCREE_VIEW_PAGE "/detail.js")
SCREE_INCLUDE_FILE(file_field, SCREE_VIEW_PAGE "/field.js")
SCREE_INCLUDE_FILE(file_layer, SCREE_VIEW_PAGE "/layer.js")
SCREE_INCLUDE_FILE(file_live, SCREE_VIEW_PAGE "/live.js")
SCREE_INCLUDE_FILE(file_main, SCREE_VIEW_PAGE "/main.js")
SCREE_INCLUDE_FILE(file_marks, SCREE_VIEW_PAGE "/marks.js")
SCREE_INCLUDE_FILE(file_orbit, SCREE_VIEW_PAGE "/orbit.js")
SCREE_INCLUDE_FILE(file_plot, SCREE_VIEW_PAGE "/plot.js")
SCREE_INCLUDE_FILE(file_scene, SCREE_VIEW_PAGE "/scene.js")
SCREE_INCLUDE_FILE(file_text, SCREE_VIEW_PAGE "/text.js")
SCREE_INCLUDE_FILE(file_touch, SCREE_VIEW_PAGE "/touch.js")
SCREE_INCLUDE_FILE(file_tracks, SCREE_VIEW_PAGE "/tracks.js")
SCREE_INCLUDE_FILE(file_walls, SCREE_VIEW_PAGE "/walls.js")
SCREE_INCLUDE_FILE(file_three, SCREE_VIEW_THREE)

namespace scree::view {

std::string_view page_text() { return file_page(); }
std::string_view style_text() { return file_style(); }

std::span<const Resource> modules() {
  static const std::array<Resource, 18> all = {{{"three", file_three()},
                                                {"scree/clip", file_clip()},
                                                {"scree/colors", file_colors()},
                                                {"scree/compare", file_compare()},
                                                {"scree/controls", file_controls()},
                                                {"scree/detail", file_detail()},
                                                {"scree/field", file_field()},
                                                {"scree/layer", file_layer()},
                                                {"scree/live", file_live()},
                                                {"scree/main", file_main()},
                                                {"scree/marks", file_marks()},
                                                {"scree/orbit", file_orbit()},
                                                {"scree/plot", file_plot()},
                                                {"scree/scene", file_scene()},
                                                {"scree/text", file_text()},
                                                {"scree/touch", file_touch()},
                                                {"scree/tracks", file_tracks()},
                                                {"scree/walls", file_walls()}}};
  return all;
}

}  // namespace scree::view
