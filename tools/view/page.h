// A page that plays a show in a browser, with all that it takes inside: it needs no server and no network.
#pragma once

#include <tools/export/show.h>

#include <string>

namespace scree::view {

// False for a build that had no npm to fetch three.js with; and what to tell then.
bool has_page();
inline constexpr const char* kNoPage =
    "this build has no pages: npm, which fetches three.js, was not found or had no network; install npm and "
    "configure the build with -DSCREE_VIEW=ON";

// The same page without a show, as a server sends it: its modules are at /module/NAME, and it asks for what
// it draws. Throws Error where has_page() is false.
std::string make_live_page(const std::string& title);

// Text in HTML. Throws Error where has_page() is false.
std::string make_page(const exports::Show& show, const std::string& title);

}  // namespace scree::view
