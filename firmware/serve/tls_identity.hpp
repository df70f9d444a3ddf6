#pragma once

#include <openssl/ssl.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "firmware/serve/serve_plan.hpp"

namespace spindle_twin::firmware {

struct EndSession {
  void operator()(SSL* session) const { SSL_free(session); }
};
using TlsSession = std::unique_ptr<SSL, EndSession>;

/// A file of [serve.tls] that cannot be used: its key there, and why.
struct TlsFileError : std::runtime_error {
  TlsFileError(std::string the_key, const std::string& why) : std::runtime_error(why), key(std::move(the_key)) {}
  std::string key;
};

/// Who the daemon is to its clients, and whose clients it takes. TLS 1.2 and 1.3, no renegotiation, no resumption: each
/// connection shows its certificate (MODBUS/TCP Security Protocol Specification).
class TlsIdentity {
 public:
  /// Reads the files. Throws TlsFileError where one is missing or no PEM, where the key is another certificate's, has a
  /// passphrase, or can be read by everybody.
  explicit TlsIdentity(const TlsPlan& plan);

  /// The server's side of a new connection; `socket` stays the caller's. Throws std::bad_alloc.
  TlsSession session(int socket) const;
  /// "Nov 23 10:00:00 2027 GMT": the last moment of the daemon's own certificate.
  std::string valid_until() const;
  /// Whether clients refuse it by now.
  bool expired() const;

 private:
  struct Free {
    void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
  };
  std::unique_ptr<SSL_CTX, Free> context_;
};

/// The role that the client's certificate names: extension 1.3.6.1.4.1.50316.802.1, a UTF8String (MODBUS/TCP Security
/// Protocol Specification, on role-based authorization). Empty: it names none, or nothing that can be read.
std::optional<std::string> role_of(const SSL* session);

/// The name in the client's certificate (RFC 2253); empty where there is none.
std::string subject_of(const SSL* session);

/// Why a handshake has failed, from OpenSSL's verdict on the certificate and its queue of errors, which is emptied;
/// else from errno.
std::string why_refused(const SSL* session);

}  // namespace spindle_twin::firmware
