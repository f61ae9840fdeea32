// Serves the page of `scree view`, and brings what pages ask for to the engine and back: HTTP and WebSocket
// by Boost.Beast.
//
// A server is for the user of the machine. It listens on loopback unless told otherwise, and refuses requests
// whose Host is a name other than localhost and that of its address: a page from elsewhere whose name was
// made to point here would have its own. WebSockets must come from this server's own page.
#pragma once

#include <tools/view/engine.h>

#include <cstdint>
#include <functional>
#include <string>

namespace scree::view {

struct ServerOptions {
  std::string address = "127.0.0.1";
  int port = 7707;  // 0: any free one
  EngineOptions engine;
};

// Serves until SIGINT or SIGTERM comes. Calls `ready(url)` once pages can be asked for. Throws Error for an
// address or a port that cannot be listened on, for what cannot be opened, and where has_page() is false.
void serve(const ServerOptions& options, const std::function<void(const std::string& url)>& ready);

}  // namespace scree::view
