#include "firmware/serve/tls_identity.hpp"

#include <openssl/err.h>
#include <openssl/objects.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <new>

namespace spindle_twin::firmware {
namespace {

template <class Thing, auto free_thing>
struct FreeBy {
  void operator()(Thing* thing) const { free_thing(thing); }
};
using Certificate = std::unique_ptr<X509, FreeBy<X509, X509_free>>;
using Utf8Text = std::unique_ptr<ASN1_UTF8STRING, FreeBy<ASN1_UTF8STRING, ASN1_UTF8STRING_free>>;
using ObjectName = std::unique_ptr<ASN1_OBJECT, FreeBy<ASN1_OBJECT, ASN1_OBJECT_free>>;
using Output = std::unique_ptr<BIO, FreeBy<BIO, BIO_free_all>>;

/// What `print` writes.
template <class Print>
std::string printed(const Print& print) {
  const Output output(BIO_new(BIO_s_mem()));
  if (!output) return {};
  print(output.get());
  char* begin = nullptr;
  const long size = BIO_get_mem_data(output.get(), &begin);
  return {begin, static_cast<std::size_t>(std::max(0L, size))};
}

std::string newest_error() {
  const unsigned long code = ERR_peek_last_error();
  const char* const reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  ERR_clear_error();
  return reason == nullptr ? "no reason is known" : reason;
}

void require_read(bool read, const char* key, const std::string& path, const char* what) {
  if (!read) throw TlsFileError(key, path + ": cannot be read as " + what + ": " + newest_error());
}

/// A pipe or a device would be read for ever.
struct stat require_file(const char* key, const std::string& path) {
  constexpr off_t longest_bytes = 1 << 20;
  struct stat found {};
  if (stat(path.c_str(), &found) != 0) throw TlsFileError(key, path + ": " + std::strerror(errno));
  if (!S_ISREG(found.st_mode) || found.st_size > longest_bytes) {
    throw TlsFileError(key, path + ": must be a file of at most 1 MiB");
  }
  return found;
}

/// Whoever has the key is the daemon to every client.
void require_private(const std::string& path) {
  if ((require_file("key", path).st_mode & S_IRWXO) != 0) {
    throw TlsFileError(
        "key", path + ": every user may read or write it; allowed: owner and group at most (chmod o= " + path + ")");
  }
}

/// There is nobody who could be asked.
int no_passphrase(char*, int, int, void*) { return 0; }

void read_own(SSL_CTX* context, const TlsPlan& plan) {
  require_file("certificate", plan.certificate);
  require_read(SSL_CTX_use_certificate_chain_file(context, plan.certificate.c_str()) == 1, "certificate",
               plan.certificate, "a certificate in PEM");
  require_private(plan.key);
  SSL_CTX_set_default_passwd_cb(context, no_passphrase);
  require_read(SSL_CTX_use_PrivateKey_file(context, plan.key.c_str(), SSL_FILETYPE_PEM) == 1, "key", plan.key,
               "the certificate's private key in PEM, without a passphrase");
}

void read_clients(SSL_CTX* context, const TlsPlan& plan) {
  constexpr const char* what = "certificates in PEM";
  require_file("clients_ca", plan.clients_ca);
  require_read(SSL_CTX_load_verify_file(context, plan.clients_ca.c_str()) == 1, "clients_ca", plan.clients_ca, what);
  STACK_OF(X509_NAME)* const names = SSL_load_client_CA_file(plan.clients_ca.c_str());
  require_read(names != nullptr, "clients_ca", plan.clients_ca, what);
  SSL_CTX_set_client_CA_list(context, names);
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  if (plan.revoked.empty()) return;
  require_file("revoked", plan.revoked);
  X509_STORE* const store = SSL_CTX_get_cert_store(context);
  X509_LOOKUP* const lookup = X509_STORE_add_lookup(store, X509_LOOKUP_file());
  require_read(lookup != nullptr && X509_load_crl_file(lookup, plan.revoked.c_str(), X509_FILETYPE_PEM) > 0, "revoked",
               plan.revoked, "a list of revoked certificates (CRL) in PEM");
  X509_STORE_set_flags(store, X509_V_FLAG_CRL_CHECK);
}

const ASN1_TIME* end_of(const SSL_CTX* context) { return X509_get0_notAfter(SSL_CTX_get0_certificate(context)); }

}  // namespace

TlsIdentity::TlsIdentity(const TlsPlan& plan) : context_(SSL_CTX_new(TLS_server_method())) {
  if (!context_) throw std::bad_alloc();
  ERR_clear_error();
  SSL_CTX* const context = context_.get();
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_cipher_list(context, "ECDHE+AESGCM:ECDHE+CHACHA20");  // of 1.2; all of 1.3 are as good
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_NO_TICKET);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_num_tickets(context, 0);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  read_own(context, plan);
  read_clients(context, plan);
}

TlsSession TlsIdentity::session(int socket) const {
  TlsSession session(SSL_new(context_.get()));
  if (!session || SSL_set_fd(session.get(), socket) != 1) throw std::bad_alloc();
  SSL_set_accept_state(session.get());
  return session;
}

std::string TlsIdentity::valid_until() const {
  return printed([&](BIO* output) { ASN1_TIME_print(output, end_of(context_.get())); });
}

bool TlsIdentity::expired() const { return X509_cmp_current_time(end_of(context_.get())) < 0; }

std::optional<std::string> role_of(const SSL* session) {
  const Certificate shown(SSL_get1_peer_certificate(session));
  const ObjectName role(OBJ_txt2obj("1.3.6.1.4.1.50316.802.1", 1));
  const int at = shown ? X509_get_ext_by_OBJ(shown.get(), role.get(), -1) : -1;
  if (at < 0) return std::nullopt;
  const ASN1_OCTET_STRING* const value = X509_EXTENSION_get_data(X509_get_ext(shown.get(), at));
  const unsigned char* bytes = ASN1_STRING_get0_data(value);
  const Utf8Text text(d2i_ASN1_UTF8STRING(nullptr, &bytes, ASN1_STRING_length(value)));
  ERR_clear_error();
  if (!text) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(ASN1_STRING_get0_data(text.get())),
                     static_cast<std::size_t>(ASN1_STRING_length(text.get())));
}

std::string subject_of(const SSL* session) {
  const Certificate shown(SSL_get1_peer_certificate(session));
  if (!shown) return {};
  return printed(
      [&](BIO* output) { X509_NAME_print_ex(output, X509_get_subject_name(shown.get()), 0, XN_FLAG_RFC2253); });
}

std::string why_refused(const SSL* session) {
  const int system = errno;
  const long verdict = SSL_get_verify_result(session);
  const bool queued = ERR_peek_error() != 0;
  std::string reason = newest_error();
  if (verdict != X509_V_OK) return X509_verify_cert_error_string(verdict);
  if (queued) return reason;
  return system != 0 ? std::strerror(system) : "the client has hung up";
}

}  // namespace spindle_twin::firmware
