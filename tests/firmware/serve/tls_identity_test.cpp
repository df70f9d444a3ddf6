#include "firmware/serve/tls_identity.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <tuple>
#include <utility>

#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace serve_tls_identity_test {

std::string refusal_of_a_certificate_of(std::size_t bytes) {
  const tests::TemporaryFolder folder;
  TlsPlan plan;
  plan.certificate = folder.file("own.pem");
  std::ofstream(plan.certificate) << std::string(bytes, 'x');
  try {
    TlsIdentity identity(plan);
  } catch (const TlsFileError& error) {
    return error.what();
  }
  return "taken";
}

TEST(TlsIdentity, files_of_up_to_a_mebibyte_are_read_and_longer_ones_are_not) {
  constexpr std::size_t longest = 1024 * 1024;
  EXPECT_NE(refusal_of_a_certificate_of(longest).find("cannot be read as a certificate in PEM"), std::string::npos);
  EXPECT_NE(refusal_of_a_certificate_of(longest + 1).find("at most 1 MiB"), std::string::npos);
}

class Identity : public ::testing::Test {
 protected:
  Identity() {
    run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=own -keyout own.key -out "
        "own.pem");
    run("openssl pkey -aes128 -passout pass:secret -in own.key -out locked.key && chmod 600 own.key locked.key");
    plan_.certificate = plan_.clients_ca = folder_.file("own.pem");
    plan_.key = folder_.file("own.key");
  }
  void run(const std::string& command) const {
    const std::string quiet = "cd " + folder_.path().string() + " && (" + command + ") 2>/dev/null";
    EXPECT_EQ(std::system(quiet.c_str()), 0) << command;  // NOLINT(cert-env33-c): what the page for users names
  }
  /// What is said of it: the key, and why without the folder.
  std::string refusal() const {
    try {
      const TlsIdentity identity(plan_);
    } catch (const TlsFileError& error) {
      const std::string text = error.what(), folder = folder_.path().string() + "/";
      return error.key + ": " + (text.starts_with(folder) ? text.substr(folder.size()) : text);
    }
    return "taken";
  }

  tests::TemporaryFolder folder_;
  TlsPlan plan_;
};

TEST_F(Identity, says_until_when_it_is_valid) {
  const TlsIdentity identity(plan_);
  EXPECT_TRUE(identity.valid_until().ends_with(" GMT")) << identity.valid_until();
  EXPECT_FALSE(identity.expired());
}

TEST_F(Identity, of_files_that_cannot_be_used_key_path_and_reason_are_named) {
  EXPECT_EQ(refusal(), "taken");
  folder_.write("none.pem", "nothing of use");
  for (const auto& [path, key, what] : {std::tuple{&plan_.certificate, "certificate", "a certificate in PEM"},
                                        {&plan_.clients_ca, "clients_ca", "certificates in PEM"}}) {
    const std::string before = std::exchange(*path, folder_.file("none.pem"));
    EXPECT_TRUE(refusal().starts_with(std::string(key) + ": none.pem: cannot be read as " + what + ": ")) << refusal();
    *path = folder_.file("missing.pem");
    EXPECT_EQ(refusal(), std::string(key) + ": missing.pem: No such file or directory");
    *path = folder_.path().string() + "/.";
    EXPECT_EQ(refusal(), std::string(key) + ": .: must be a file of at most 1 MiB");
    *path = before;
  }
  plan_.revoked = folder_.file("none.pem");
  EXPECT_TRUE(
      refusal().starts_with("revoked: none.pem: cannot be read as a list of revoked certificates (CRL) in PEM: "))
      << refusal();
}

TEST_F(Identity, a_key_is_for_its_owner_has_no_passphrase_and_is_the_certificates) {
  run("chmod 640 own.key");
  EXPECT_EQ(refusal(), "taken");
  for (const char* mode : {"644", "642", "641"}) {
    run(std::string("chmod ") + mode + " own.key");
    const std::string path = folder_.file("own.key");
    EXPECT_EQ(refusal(), "key: own.key: every user may read or write it; allowed: owner and group at most (chmod o= " +
                             path + ")");
  }
  const std::string no_key = " cannot be read as the certificate's private key in PEM, without a passphrase: ";
  plan_.key = folder_.file("locked.key");
  EXPECT_NE(refusal().find("key: locked.key:" + no_key), std::string::npos) << refusal();
  run("openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:P-256 -out other.key && chmod 600 other.key");
  plan_.key = folder_.file("other.key");
  EXPECT_EQ(refusal(), "key: other.key:" + no_key + "key values mismatch");
}

}  // namespace serve_tls_identity_test
}  // namespace spindle_twin::firmware
