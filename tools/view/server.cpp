// See server.h.
#include <scree/error.h>
#include <tools/view/page.h>
#include <tools/view/resources.h>
#include <tools/view/server.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <charconv>
#include <csignal>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

namespace scree::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Problem = boost::system::error_code;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

constexpr std::size_t kMostRequest = 64 << 10;              // bytes, of what a page asks
constexpr std::size_t kMostWaiting = std::size_t{1} << 30;  // bytes that a page has not taken yet

// "localhost:80" -> "localhost", "[::1]:80" -> "::1".
std::string_view host_name(std::string_view host) {
  if (host.starts_with("[")) return host.substr(1, host.find(']') - 1);
  return host.substr(0, host.find(':'));
}

bool is_address(std::string_view text) {
  Problem problem;
  asio::ip::make_address(std::string(text), problem);
  return !problem;
}

std::string_view text_of(beast::string_view text) { return {text.data(), text.size()}; }

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// Of "a=1&b=2".
std::optional<std::uint64_t> parameter(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    const std::string_view each = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), each.size() + 1));
    if (each.starts_with(name) && each.substr(name.size()).starts_with("="))
      return number_in(each.substr(name.size() + 1));
  }
  return std::nullopt;
}

class Socket;

// What the connections share. All of it is used on the thread of `context` alone.
struct Shared {
  asio::io_context context;
  std::string address;
  std::unique_ptr<Engine> engine;
  std::map<PageId, std::weak_ptr<Socket>> sockets;
  PageId next = 1;

  void send(PageId page, const Bytes& message, bool is_text);
};

// A page that is connected.
class Socket : public std::enable_shared_from_this<Socket> {
 public:
  Socket(Shared& shared, beast::tcp_stream stream) : shared_(shared), stream_(std::move(stream)) {}

  void begin(const Request& request) {
    beast::get_lowest_layer(stream_).expires_never();
    stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    stream_.read_message_max(kMostRequest);
    stream_.async_accept(request, [self = shared_from_this()](Problem problem) {
      if (problem) return;
      self->page_ = self->shared_.next++;
      self->shared_.sockets[self->page_] = self;
      self->shared_.engine->join(self->page_);
      self->read();
    });
  }

  void send(Bytes message, bool is_text) {
    waiting_bytes_ += message->size();
    waiting_.push_back({std::move(message), is_text});
    if (waiting_bytes_ > kMostWaiting) return end();
    if (waiting_.size() == 1) write();
  }

 private:
  struct Message {
    Bytes bytes;
    bool is_text;
  };

  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](Problem problem, std::size_t) {
      if (problem) return self->end();
      self->shared_.engine->ask(self->page_, beast::buffers_to_string(self->buffer_.data()));
      self->buffer_.clear();
      self->read();
    });
  }

  void write() {
    stream_.text(waiting_.front().is_text);
    stream_.async_write(asio::buffer(*waiting_.front().bytes),
                        [self = shared_from_this()](Problem problem, std::size_t) {
                          if (problem) return self->end();
                          self->waiting_bytes_ -= self->waiting_.front().bytes->size();
                          self->waiting_.pop_front();
                          if (!self->waiting_.empty()) self->write();
                        });
  }

  void end() {
    if (shared_.sockets.erase(page_) == 0) return;
    shared_.engine->leave(page_);
    beast::get_lowest_layer(stream_).close();
  }

  Shared& shared_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer buffer_;
  PageId page_ = 0;
  std::deque<Message> waiting_;
  std::size_t waiting_bytes_ = 0;
};

void Shared::send(PageId page, const Bytes& message, bool is_text) {
  const auto socket = sockets.find(page);
  if (socket == sockets.end()) return;
  if (const auto alive = socket->second.lock()) alive->send(message, is_text);
}

// A connection that asks for files, or becomes a page's socket.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Shared& shared, asio::ip::tcp::socket socket) : shared_(shared), stream_(std::move(socket)) {}

  void read() {
    request_ = {};
    stream_.expires_after(std::chrono::seconds(60));
    http::async_read(stream_, buffer_, request_, [self = shared_from_this()](Problem problem, std::size_t) {
      if (!problem) self->handle();
    });
  }

 private:
  void handle() {
    const std::string_view host = text_of(request_[http::field::host]);
    const std::string_view name = host_name(host);
    if (name != "localhost" && name != shared_.address && !is_address(name))
      return say(http::status::forbidden, "This server is asked for by another name than its own.\n");
    const std::string_view target = text_of(request_.target());
    if (websocket::is_upgrade(request_) && target == "/socket") {
      const std::string_view origin = text_of(request_[http::field::origin]);
      if (!origin.empty() && origin != "http://" + std::string(host))
        return say(http::status::forbidden, "This server is asked by a page that is not its own.\n");
      return std::make_shared<Socket>(shared_, std::move(stream_))->begin(request_);
    }
    if (request_.method() != http::verb::get)
      return say(http::status::method_not_allowed, "This server gives files only.\n");
    const std::string_view path = target.substr(0, target.find('?'));
    const std::string_view query = path.size() < target.size() ? target.substr(path.size() + 1) : "";
    if (path == "/") return give(make_live_page("scree view"), "text/html; charset=utf-8");
    constexpr std::string_view kModule = "/module/", kRecording = "/recording/", kPage = "/page/";
    // What takes work is for the user alone, not for pages from elsewhere that name it.
    const std::string_view site = text_of(request_["Sec-Fetch-Site"]);
    const bool is_foreign = !site.empty() && site != "same-origin" && site != "none";
    if (is_foreign && !path.starts_with(kModule))
      return say(http::status::forbidden, "This server is asked by a page that is not its own.\n");
    if (path.starts_with(kModule)) return give_module(path.substr(kModule.size()));
    if (path.starts_with(kRecording)) return give_recording(path.substr(kRecording.size()));
    if (path.starts_with(kPage)) return give_page(path.substr(kPage.size()), query);
    say(http::status::not_found, "There is no such file.\n");
  }

  void give_module(std::string_view name) {
    for (const Resource& module : modules()) {
      if (module.name == name) return give(std::string(module.text), "text/javascript; charset=utf-8");
    }
    say(http::status::not_found, "There is no such module.\n");
  }

  void give_recording(std::string_view text) {
    const std::optional<std::uint64_t> track = number_in(text);
    if (!track) return say(http::status::not_found, "There is no such track.\n");
    shared_.engine->copy_recording(
        static_cast<std::uint32_t>(*track),
        taker("application/octet-stream", "track-" + std::string(text) + ".scree"));
  }

  void give_page(std::string_view text, std::string_view query) {
    const std::optional<std::uint64_t> track = number_in(text), from = parameter(query, "from"),
                                       to = parameter(query, "to"), every = parameter(query, "every");
    if (!track || !from || !to) return say(http::status::bad_request, "A page takes a track, from and to.\n");
    shared_.engine->make_page(*track, *from, *to, every.value_or(1),
                              taker("text/html; charset=utf-8", "track-" + std::string(text) + ".html"));
  }

  // Called by the engine, on its own thread.
  Engine::Take taker(const std::string& type, const std::string& file) {
    stream_.expires_never();
    return [self = shared_from_this(), type, file](std::string bytes, std::string error) {
      asio::post(self->shared_.context, [self, type, file, bytes = std::move(bytes), error]() mutable {
        if (!error.empty()) return self->say(http::status::bad_request, error + "\n");
        self->give(std::move(bytes), type, "attachment; filename=\"" + file + "\"");
      });
    };
  }

  void say(http::status status, std::string text) {
    respond(status, std::move(text), "text/plain; charset=utf-8", {});
  }
  void give(std::string bytes, const std::string& type, const std::string& disposition = {}) {
    respond(http::status::ok, std::move(bytes), type, disposition);
  }
  void respond(http::status status, std::string bytes, const std::string& type,
               const std::string& disposition) {
    auto response = std::make_shared<Response>(status, request_.version());
    response->set(http::field::content_type, type);
    response->set(http::field::cache_control, "no-store");
    response->set("X-Content-Type-Options", "nosniff");
    if (!disposition.empty()) response->set(http::field::content_disposition, disposition);
    response->keep_alive(request_.keep_alive());
    response->body() = std::move(bytes);
    response->prepare_payload();
    stream_.expires_after(std::chrono::minutes(10));
    http::async_write(stream_, *response,
                      [self = shared_from_this(), response](Problem problem, std::size_t) {
                        if (problem) return;
                        if (response->keep_alive()) return self->read();
                        Problem ignored;
                        self->stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
                      });
  }

  Shared& shared_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  Request request_;
};

struct Door {
  asio::ip::tcp::acceptor acceptor;
  asio::steady_timer rest;
};

void accept(Shared& shared, Door& door) {
  door.acceptor.async_accept([&](Problem problem, asio::ip::tcp::socket socket) {
    if (!problem) {
      std::make_shared<Connection>(shared, std::move(socket))->read();
      return accept(shared, door);
    }
    // As when no more files can be opened, which lasts.
    door.rest.expires_after(std::chrono::milliseconds(100));
    door.rest.async_wait([&](Problem) { accept(shared, door); });
  });
}

asio::ip::tcp::acceptor listen(asio::io_context& context, const ServerOptions& options) {
  Problem problem;
  const asio::ip::address address = asio::ip::make_address(options.address, problem);
  if (problem) throw Error("--address " + options.address + ": is no IP address");
  if (options.port < 0 || options.port > 65535)
    throw Error("--port " + std::to_string(options.port) + " must be from 0 to 65535");
  const asio::ip::tcp::endpoint end(address, static_cast<std::uint16_t>(options.port));
  asio::ip::tcp::acceptor acceptor(context);
  acceptor.open(end.protocol(), problem);
  if (!problem) acceptor.set_option(asio::socket_base::reuse_address(true), problem);
  if (!problem) acceptor.bind(end, problem);
  if (!problem) acceptor.listen(asio::socket_base::max_listen_connections, problem);
  if (problem) {
    throw Error("--port " + std::to_string(options.port) + ": cannot listen at " + options.address + ": " +
                problem.message());
  }
  return acceptor;
}

}  // namespace

void serve(const ServerOptions& options, const std::function<void(const std::string&)>& ready) {
  if (!has_page()) throw Error(kNoPage);
  Shared shared;
  shared.address = options.address;
  Door door{listen(shared.context, options), asio::steady_timer(shared.context)};
  // From here on a signal ends the server in order, which takes its files away; a second one ends it at once.
  asio::signal_set signals(shared.context, SIGINT, SIGTERM, SIGHUP);
  signals.async_wait([&](Problem, int) {
    signals.clear();
    shared.context.stop();
  });
  shared.engine = std::make_unique<Engine>(options.engine, [&](PageId page, Bytes message, bool is_text) {
    asio::post(shared.context, [&shared, page, message = std::move(message), is_text] {
      shared.send(page, message, is_text);
    });
  });
  accept(shared, door);
  const asio::ip::tcp::endpoint end = door.acceptor.local_endpoint();
  const std::string host =
      end.address().is_v6() ? "[" + end.address().to_string() + "]" : end.address().to_string();
  ready("http://" + host + ":" + std::to_string(end.port()) + "/");
  shared.context.run();
  shared.engine.reset();
}

}  // namespace scree::view
