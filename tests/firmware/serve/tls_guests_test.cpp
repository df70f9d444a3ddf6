#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "firmware/serve/tls_front.hpp"
#include "tests/firmware/support/http_serving.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/no_descriptors.hpp"
#include "tests/firmware/support/serving.hpp"
#include "tests/firmware/support/standing_clock.hpp"
#include "tests/firmware/support/troubled_poll.hpp"
#include "tests/support/temporary_folder.hpp"

/// Clients by TLS that show a certificate, and the server that they reach, on a clock that stands.
namespace spindle_twin::firmware {
namespace serve_tls_guests_test {

using namespace serving;
using Other = http_serving::Client;

/// One that shows the certificate NAME.pem. Every wait ends after 5 s.
class Guest {
 public:
  Guest(int port, const std::string& name, std::uint32_t from = INADDR_LOOPBACK)
      : context_(SSL_CTX_new(TLS_client_method())), socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    SSL_CTX_use_certificate_chain_file(context_.get(), (name + ".pem").c_str());
    SSL_CTX_use_PrivateKey_file(context_.get(), (name + ".key").c_str(), SSL_FILETYPE_PEM);
    const timeval patience{5, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sockaddr_in end{};
    end.sin_family = AF_INET;
    end.sin_addr.s_addr = htonl(from);
    (void)!::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&end), sizeof end);
    end.sin_port = htons(static_cast<std::uint16_t>(port));
    end.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    (void)!::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&end), sizeof end);
    session_.reset(SSL_new(context_.get()));
    SSL_set_fd(session_.get(), socket_.get());
    SSL_set_connect_state(session_.get());
  }
  /// Shakes hands first, where that is not done. Empty: there is no answer.
  Bytes ask(const Bytes& pdu) {
    const Bytes frame = serving::Client::framed(pdu);
    Bytes reply(260);
    ERR_clear_error();
    if (SSL_write(session_.get(), frame.data(), static_cast<int>(frame.size())) <= 0) return {};
    reply.resize(
        static_cast<std::size_t>(std::max(0, SSL_read(session_.get(), reply.data(), static_cast<int>(reply.size())))));
    return reply;
  }
  /// Whether the other side says good-bye; waits for it.
  bool hears_good_bye() {
    char byte = 0;
    ERR_clear_error();
    return SSL_read(session_.get(), &byte, 1) <= 0 && (SSL_get_shutdown(session_.get()) & SSL_RECEIVED_SHUTDOWN) != 0;
  }
  void reset() {
    const linger none{1, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_LINGER, &none, sizeof none);
    socket_ = Descriptor();
  }

 private:
  struct Free {
    void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
  };
  std::unique_ptr<SSL_CTX, Free> context_;
  Descriptor socket_;
  TlsSession session_;
};

/// A front in its own thread.
struct Running {
  Running(const ServePlan& plan, Clock& clock, ModbusServer& server)
      : front(plan, clock, server), thread([this] { front.run(); }) {}
  ~Running() {
    front.stop();
    thread.join();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  TlsFront front;
  std::thread thread;
};

class Guests : public ::testing::Test {
 protected:
  Guests() {
    // The role is its first extension.
    folder_.write("role.conf",
                  "[req]\ndistinguished_name=dn\nx509_extensions=first\n[dn]\n[first]\n"
                  "1.3.6.1.4.1.50316.802.1=ASN1:UTF8String:Operator\n");
    make("operator", " -config " + name("role.conf"));
    make("nobody", "");
    run("cd " + folder_.path().string() +
        " && cat operator.pem nobody.pem > clients.pem && touch index && printf '[ca]\\ndefault_ca=x\\n[x]\\n"
        "database=index\\ndefault_md=sha256\\ndefault_crl_days=30\\n' > ca.conf && openssl ca -gencrl -config ca.conf "
        "-cert nobody.pem -keyfile nobody.key -out revoked.pem 2>/dev/null && openssl ca -gencrl -config ca.conf "
        "-cert operator.pem -keyfile operator.key 2>/dev/null >> revoked.pem");
    plan_.allow = {*parse_address_range("127.0.0.0/16")};
    plan_.tls.emplace();
    plan_.tls->port = 0;
    plan_.tls->certificate = name("operator") + ".pem";
    plan_.tls->key = name("operator") + ".key";
    plan_.tls->clients_ca = name("clients") + ".pem";
    plan_.tls->revoked = name("revoked") + ".pem";
  }
  static void run(const std::string& command) {
    EXPECT_EQ(std::system(command.c_str()), 0) << command;  // NOLINT(cert-env33-c): what the page for users names
  }
  void make(const std::string& whose, const std::string& more) const {
    run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=" + whose + more + " -keyout " +
        name(whose) + ".key -out " + name(whose) + ".pem 2>/dev/null && chmod 600 " + name(whose) + ".key");
  }
  std::string name(const std::string& whose) const { return folder_.file(whose); }
  void begin() { running_.emplace(plan_, clock_, behind_.server); }
  int port() const { return running_->front.port(); }
  std::unique_ptr<Guest> guest(const std::string& whose = "operator", std::uint32_t from = INADDR_LOOPBACK) const {
    return std::make_unique<Guest>(port(), name(whose), from);
  }
  /// The front has looked at all that was there before: it has turned a stranger away.
  void look() const {
    Other stranger(port(), INADDR_LOOPBACK + 0x10000);
    EXPECT_TRUE(stranger.is_ended());
  }
  bool has_said(const std::string& words) const { return log_.text().find(words) != std::string::npos; }
  /// Waits for it, five seconds at most: of what one turn of the front finds, it deals with newcomers first.
  bool says(const std::string& words) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (!has_said(words) && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    return has_said(words);
  }

  /// As the program does: OpenSSL writes to who may have gone.
  struct NoBrokenPipe {
    NoBrokenPipe() : before(std::signal(SIGPIPE, SIG_IGN)) {}
    ~NoBrokenPipe() { std::signal(SIGPIPE, before); }
    NoBrokenPipe(const NoBrokenPipe&) = delete;
    NoBrokenPipe& operator=(const NoBrokenPipe&) = delete;
    void (*before)(int);
  };
  const NoBrokenPipe ignored_;
  const Logged log_;
  tests::TemporaryFolder folder_;
  StandingClock clock_;
  serving::Serving behind_;
  ServePlan plan_ = serving::Serving::plan();
  std::optional<Running> running_;
};

TEST_F(Guests, who_shows_a_certificate_is_served_and_may_stay) {
  begin();
  const auto stays = guest();
  EXPECT_EQ(payload(stays->ask(read_known)), known_words);
  clock_.pass(1000 * ns_per_s);
  look();
  EXPECT_EQ(payload(stays->ask(read_known)), known_words);
}

TEST_F(Guests, one_that_does_not_end_its_handshake_has_five_seconds_whoever_else_is_there) {
  begin();
  Other slow(port());
  slow.send("\x16");
  const auto stays = guest();
  EXPECT_EQ(payload(stays->ask(read_known)), known_words);
  clock_.pass(5 * ns_per_s - 1);
  look();
  EXPECT_TRUE(slow.hears_nothing());
  clock_.pass(1);
  EXPECT_TRUE(slow.is_ended()) << "though nothing else happens";
  EXPECT_EQ(payload(stays->ask(read_known)), known_words);
}

TEST_F(Guests, role_and_address_together_say_who_may_write) {
  const Bytes write = write_single(Register::command_speed, 5);
  using Roles = std::optional<std::vector<std::string>>;
  const std::vector<AddressRange> all = plan_.write, others{*parse_address_range("127.0.0.2")};
  struct Case {
    Roles roles;
    std::string whose;
    bool may;
  };
  const auto roles = [](std::initializer_list<std::string> names) { return Roles(std::vector<std::string>(names)); };
  const std::vector<Case> cases{{std::nullopt, "operator", true},
                                {std::nullopt, "nobody", true},
                                {roles({"Operator"}), "operator", true},
                                {roles({"Operator"}), "nobody", false},
                                {roles({"Viewer", "Operator"}), "operator", true},
                                {roles({"Viewer"}), "operator", false},
                                {roles({}), "nobody", false}};
  for (const Case& each : cases) {
    for (const auto& write_from : {all, others}) {
      plan_.write = write_from;
      plan_.tls->write_roles = each.roles;
      begin();
      const bool may = each.may && write_from == all;
      const auto asks = guest(each.whose);
      EXPECT_EQ(exception_of(asks->ask(write)), may ? 0 : 2) << each.whose << " " << each.may;
      EXPECT_EQ(payload(asks->ask(read_known)), known_words);
      running_.reset();
    }
  }
  EXPECT_TRUE(says("client 127.0.0.1 by TLS: CN=operator, role Operator, may write\n")) << log_.text();
}

TEST_F(Guests, there_are_sixteen_more_at_once_than_the_server_may_have_and_one_that_breaks_off_makes_room) {
  plan_.connections = 2;
  begin();
  std::list<std::unique_ptr<Guest>> guests;
  const auto is_served = [&](std::uint32_t from) {
    guests.push_back(guest("operator", from));
    return payload(guests.back()->ask(read_known)) == known_words;
  };
  for (std::uint32_t n = 0; n < 18; ++n) EXPECT_TRUE(is_served(INADDR_LOOPBACK + n % 2)) << n;
  EXPECT_FALSE(is_served(INADDR_LOOPBACK + 2));
  EXPECT_TRUE(says("client 127.0.0.3 by TLS refused: too many connections are open\n")) << log_.text();
  guests.front()->reset();
  bool is_room = false;
  for (int n = 0; n < 100 && !is_room; ++n) is_room = is_served(INADDR_LOOPBACK + 2);
  EXPECT_TRUE(is_room);
  EXPECT_FALSE(is_served(INADDR_LOOPBACK + 2)) << "and no more than one";
}

TEST_F(Guests, a_server_that_ends_a_connection_ends_it_for_the_guest) {
  ServePlan impatient = Serving::plan();
  impatient.idle_s = 0.6;  // so long may the handshake of a busy computer take
  serving::Serving ends(impatient);
  const Running running(plan_, clock_, ends.server);
  Guest waits(running.front.port(), name("operator"));
  EXPECT_EQ(payload(waits.ask(read_known)), known_words);
  EXPECT_TRUE(waits.hears_good_bye());
}

/// Each of the four counts from the next client on, by the second that it was changed in and by less.
TEST_F(Guests, files_that_have_changed_are_read_again_and_others_are_not) {
  begin();
  const auto times_read = [&] {
    EXPECT_EQ(payload(guest()->ask(read_known)), known_words);
    const std::string text = log_.text(), words = "files have changed and are read";
    int found = 0;
    for (std::size_t at = 0; (at = text.find(words, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  EXPECT_EQ(times_read(), 0);
  int changed = 0;
  for (const char* file : {"operator.pem", "operator.key", "clients.pem", "revoked.pem"}) {
    for (const auto& later : {std::chrono::nanoseconds(std::chrono::seconds(1)), std::chrono::nanoseconds(1)}) {
      const std::filesystem::path path = folder_.file(file);
      std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + later);
      EXPECT_EQ(times_read(), ++changed) << file;
      EXPECT_EQ(times_read(), changed) << file;
    }
  }
}

TEST_F(Guests, a_changed_file_that_cannot_be_used_is_said_once_and_changes_nothing) {
  begin();
  folder_.write("clients.pem", "nothing of use");
  for (int n = 0; n < 2; ++n) EXPECT_EQ(payload(guest()->ask(read_known)), known_words);
  const std::string text = log_.text(), words = "error serve.tls.clients_ca: ";
  EXPECT_NE(text.find(words), std::string::npos) << text;
  EXPECT_EQ(text.find(words), text.rfind(words)) << text;
}

TEST_F(Guests, without_a_descriptor_nobody_is_accepted_for_a_second_and_then_who_has_waited) {
  begin();
  const auto here = guest();
  EXPECT_EQ(payload(here->ask(read_known)), known_words);
  Other waits(0);           // has its descriptor, and no connection yet
  const auto looks = [&] {  // what the front accepts then, it accepts behind an answer: so two of them
    for (int n = 0; n < 2; ++n) EXPECT_EQ(payload(here->ask(read_known)), known_words);
  };
  {
    const NoDescriptors none;
    waits.connect(port());
    // A busy kernel brings the connection some turns later.
    for (int n = 0; n < 1000 && !has_said("no client can be accepted"); ++n) looks();
  }
  EXPECT_TRUE(says("error server by TLS: no client can be accepted: Too many open files\n")) << log_.text();
  waits.send("no TLS at all, and longer than the head of a record");
  clock_.pass(ns_per_s - 1);
  looks();
  EXPECT_TRUE(waits.hears_nothing());
  clock_.pass(1);
  looks();
  EXPECT_TRUE(waits.is_ended());
}

TEST_F(Guests, without_descriptors_for_its_way_to_the_server_a_guest_is_ended_and_it_is_said) {
  begin();
  const auto here = guest(), guest_without_way = guest();
  // The front has done with accepting.
  for (int n = 0; n < 2; ++n) EXPECT_EQ(payload(here->ask(read_known)), known_words);
  {
    const NoDescriptors none;
    EXPECT_EQ(guest_without_way->ask(read_known), Bytes{});
  }
  EXPECT_TRUE(says("error server by TLS: no way to the server: Too many open files\n")) << log_.text();
  EXPECT_EQ(payload(guest()->ask(read_known)), known_words);
}

TEST_F(Guests, behind_a_poll_that_failed_it_rests_a_tenth_of_a_second_and_says_so) {
  RestingClock clock;
  const Running running(plan_, clock, behind_.server);
  Guest asks(running.front.port(), name("operator"));
  EXPECT_EQ(payload(asks.ask(read_known)), known_words);
  Other wakes(0);
  {
    const NoPoll none;
    wakes.connect(running.front.port());  // the next poll fails, or the one behind it
    clock.wait_until_it_rests();
  }
  clock.wake();
  EXPECT_EQ(clock.rest_ns, ns_per_s / 10);
  EXPECT_EQ(payload(asks.ask(read_known)), known_words);
  EXPECT_TRUE(says("error server by TLS: poll: Invalid argument\n")) << log_.text();
}

TEST_F(Guests, who_breaks_off_within_its_handshake_is_refused_with_the_systems_reason) {
  begin();
  Other breaks(port());
  breaks.send("\x16");
  look();
  breaks.reset();
  look();
  EXPECT_TRUE(says("client 127.0.0.1 by TLS refused: Connection reset by peer\n")) << log_.text();
}

TEST_F(Guests, a_signal_ends_nothing_and_is_no_error) {
  const Interruption quiet;
  begin();
  const auto stays = guest();
  for (int n = 0; n < 20; ++n) {
    Interruption::of(running_->thread);
    EXPECT_EQ(payload(stays->ask(read_known)), known_words);
  }
  EXPECT_FALSE(has_said("error")) << log_.text();
}

TEST_F(Guests, it_sleeps_while_nobody_says_anything) {
  begin();
  Other slow(port());
  slow.send("\x16");
  const auto stays = guest();
  EXPECT_EQ(payload(stays->ask(read_known)), known_words);
  long before = -1;
  for (int n = 0; n < 20 && before != clock_.asked; ++n) {
    before = clock_.asked;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(before, clock_.asked);
}

}  // namespace serve_tls_guests_test
}  // namespace spindle_twin::firmware
