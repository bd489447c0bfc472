// The routes, on cpp-httplib.
// SPDX-License-Identifier: MIT
#include "firmware/control_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <semaphore>
#include <thread>

#include "pipeline/frame/error.h"
#include "pipeline/frame/jpeg_writer.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using httplib::Request;
using httplib::Response;
using Answered = httplib::Server::HandlerResponse;

constexpr std::size_t kThreads = 4;
constexpr std::size_t kLargestBody = 4096;       // bytes
constexpr std::ptrdiff_t kMostConnections = 16;  // beyond them nobody is accepted until one is served
constexpr auto kPreviewAge = 1500ms;             // older ones are made anew
constexpr auto kPreviewPatience = 2s;
constexpr int kPreviewQuality = 80;

constexpr const char* kJson = "application/json";

// The page's own style and script, pictures and data from here alone, in nobody's frame.
constexpr const char* kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src 'self' blob: data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

void refuse(Response& response, int status, std::string_view error) {
  response.status = status;
  response.set_content(error_json(error), kJson);
}

// The library's pool takes any number of connections, and with them all the files a process may open, which
// the show needs too.
class BoundedPool final : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> serve) override {
    free_.acquire();
    pool_.enqueue([this, serve = std::move(serve)] {
      serve();
      free_.release();
    });
  }
  void shutdown() override { pool_.shutdown(); }

 private:
  std::counting_semaphore<kMostConnections> free_{kMostConnections};
  httplib::ThreadPool pool_{kThreads};
};

class HttpServer final : public ControlServer {
 public:
  HttpServer(const ControlAddress& address, std::string token, ShowFacts facts, ControlLink& link,
             Clock& clock);
  ~HttpServer() override {
    server_.stop();
    thread_.join();
  }
  const ControlAddress& address() const override { return address_; }

 private:
  void add_routes();
  ShowFacts facts() const { return link_.reload ? link_.reload->facts() : facts_; }
  Answered guard(const Request& request, Response& response) const;
  void command(const Request& request, Response& response);
  void answer_picture(Preview* preview, Response& response);

  ControlAddress address_;
  std::string token_;
  ShowFacts facts_;
  ControlLink& link_;
  Clock& clock_;
  httplib::Server server_;
  std::thread thread_;
};

HttpServer::HttpServer(const ControlAddress& address, std::string token, ShowFacts facts, ControlLink& link,
                       Clock& clock)
    : address_(address), token_(std::move(token)), facts_(std::move(facts)), link_(link), clock_(clock) {
  // Not the library's default, which lets two players share a port.
  server_.set_socket_options([](int socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  server_.new_task_queue = [] { return new BoundedPool; };
  server_.set_keep_alive_max_count(1);  // nobody keeps a thread to himself
  server_.set_read_timeout(2s);
  server_.set_write_timeout(2s);
  server_.set_payload_max_length(kLargestBody);
  add_routes();
  errno = 0;
  if (address_.port == 0)
    address_.port = server_.bind_to_any_port(address_.host);
  else if (!server_.bind_to_port(address_.host, address_.port))
    address_.port = -1;
  if (address_.port < 0) {
    throw Failure(
        fmt::format("control: {}: cannot listen there: {}", describe(address), std::strerror(errno)));
  }
  thread_ = std::thread([this] {
    setpriority(PRIO_PROCESS, 0, 10);  // this thread's and those it begins: the show comes first
    server_.listen_after_bind();
  });
  while (!server_.is_running()) std::this_thread::sleep_for(1ms);
}

void HttpServer::add_routes() {
  server_.set_default_headers({{"Cache-Control", "no-store"},
                               {"Content-Security-Policy", kPolicy},
                               {"Referrer-Policy", "no-referrer"},
                               {"X-Content-Type-Options", "nosniff"}});
  server_.set_pre_routing_handler(
      [this](const Request& request, Response& response) { return guard(request, response); });
  server_.set_error_handler(httplib::Server::HandlerWithResponse([](const Request&, Response& response) {
    if (!response.body.empty()) return Answered::Handled;
    const std::string_view why = response.status == 404   ? "there is no such page"
                                 : response.status == 413 ? "too long"
                                                          : "the request is not as expected";
    response.set_content(error_json(why), kJson);
    return Answered::Handled;
  }));
  server_.set_exception_handler([](const Request&, Response& response, std::exception_ptr error) {
    try {
      std::rethrow_exception(error);
    } catch (const InputError& wrong) {
      refuse(response, 400, wrong.what());
    } catch (const std::exception& failed) {
      refuse(response, 500, failed.what());
    }
  });
  server_.Get("/", [](const Request&, Response& response) {
    response.set_content(kControlPage, "text/html; charset=utf-8");
  });
  server_.Get("/api/status", [this](const Request&, Response& response) {
    response.set_content(
        status_json(read_status(link_), facts(), link_.reload ? link_.reload->trouble() : ""), kJson);
  });
  server_.Get("/api/cues", [this](const Request&, Response& response) {
    response.set_content(cues_json(link_.status.read(), facts()), kJson);
  });
  server_.Get("/api/log", [this](const Request&, Response& response) {
    response.set_content(log_json(link_.log.lines()), kJson);
  });
  server_.Get("/metrics", [this](const Request&, Response& response) {
    response.set_content(metrics_text(read_status(link_), facts()), "text/plain; version=0.0.4");
  });
  server_.Get("/trace", [this](const Request&, Response& response) {
    response.set_content(link_.trace.json(), kJson);
  });
  server_.Get("/preview.jpg",
              [this](const Request&, Response& response) { answer_picture(link_.preview, response); });
  server_.Get(R"(/faces/([1-9])\.jpg)", [this](const Request& request, Response& response) {
    const auto view = static_cast<std::size_t>(request.matches[1].str()[0] - '1');
    const std::size_t views = std::min(views_of(facts(), link_.status.read()).size(), FacePreviews::kMost);
    answer_picture(link_.faces && view < views ? &link_.faces->of(view) : nullptr, response);
  });
  server_.Post("/api/command",
               [this](const Request& request, Response& response) { command(request, response); });
}

// Before anything of the body is read.
Answered HttpServer::guard(const Request& request, Response& response) const {
  // Bodies whose length is not said, or that swell.
  if (request.has_header("Transfer-Encoding") || request.has_header("Content-Encoding")) {
    refuse(response, 411, "expected a body of a given length, as it is");
    return Answered::Handled;
  }
  const std::string host = request.get_header_value("Host");
  const std::string origin = request.get_header_value("Origin");
  const std::string authorization = request.get_header_value("Authorization");
  // The page itself has no secrets: it asks for the token and speaks it.
  if (!token_.empty() && request.method == "GET" && request.path == "/") return Answered::Unhandled;
  switch (access({host, origin, authorization}, token_)) {
    case Access::kGranted:
      return Answered::Unhandled;
    case Access::kNoToken:
      response.set_header("WWW-Authenticate", "Bearer");
      refuse(response, 401, "expected the header Authorization: Bearer TOKEN");
      break;
    case Access::kForeign:
      refuse(response, 403, "expected a request from this machine, to a loopback address");
      break;
  }
  return Answered::Handled;
}

void HttpServer::command(const Request& request, Response& response) {
  // No form of any page can send this type.
  if (!request.get_header_value("Content-Type").starts_with(kJson)) {
    return refuse(response, 415, "expected Content-Type: application/json");
  }
  const ShowFacts facts = this->facts();
  const PlayerCommand command = parse_command_json(request.body, facts);
  if (!link_.commands.push(command)) return refuse(response, 503, "too many commands at once; try again");
  link_.log.info(Topic::kControl, fmt::format("{}: {}", request.remote_addr, describe(command, facts.cues)));
  response.set_content(R"({"taken": true})"
                       "\n",
                       kJson);
}

void HttpServer::answer_picture(Preview* preview, Response& response) {
  if (!preview) return refuse(response, 404, "there is no such picture");
  ImageBuffer picture;
  const std::int64_t first = preview->newest(picture);
  std::int64_t number = first;
  const bool old = number == 0 || clock_.now() - preview->made_at() > kPreviewAge;
  for (const auto until = clock_.now() + kPreviewPatience; old && number == first && clock_.now() < until;) {
    std::this_thread::sleep_for(20ms);
    number = preview->newest(picture);
  }
  if (number == 0) return refuse(response, 503, "there is no picture yet; try again");
  response.set_content(encode_jpeg(as_const(picture.pixels()), kPreviewQuality), "image/jpeg");
}

}  // namespace

std::unique_ptr<ControlServer> start_control_server(const ControlAddress& address, std::string token,
                                                    ShowFacts facts, ControlLink& link, Clock& clock) {
  if (!address.loopback && token.empty()) {
    throw InputError(fmt::format(
        "control: {}: expected a token for an address that others can reach; --token-file FILE or "
        "control.token_file names one",
        describe(address)));
  }
  return std::make_unique<HttpServer>(address, std::move(token), std::move(facts), link, clock);
}

std::string ask_status(const ControlAddress& address, const std::string& token) {
  httplib::Client client(address.host, address.port);
  client.set_connection_timeout(2s);
  client.set_read_timeout(5s);
  httplib::Headers headers;
  if (!token.empty()) headers.emplace("Authorization", "Bearer " + token);
  const httplib::Result result = client.Get("/api/status", headers);
  if (!result) {
    throw Failure(
        fmt::format("{}: no player answers ({})", describe(address), httplib::to_string(result.error())));
  }
  if (result->status == 401)
    throw Failure(
        fmt::format("{}: the player wants its token; expected --token-file FILE", describe(address)));
  if (result->status != 200)
    throw Failure(fmt::format("{}: the player answers with {}", describe(address), result->status));
  return result->body;
}

}  // namespace cupola
