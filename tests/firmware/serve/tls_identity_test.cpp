#include "firmware/serve/tls_identity.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

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

}  // namespace serve_tls_identity_test
}  // namespace spindle_twin::firmware
