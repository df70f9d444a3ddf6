#include "firmware/login/accounts.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace login_accounts_test {

const std::string hash = "$argon2id$v=19$m=8,t=1,p=1$c2FsdHNhbHRzYWx0c2FsdA$" + std::string(43, 'A');

class Accounts : public ::testing::Test {
 protected:
  void write(const std::string& text, std::filesystem::perms mode = std::filesystem::perms(0640)) const {
    std::ofstream(path_) << text;
    std::filesystem::permissions(path_, mode);
  }
  std::string refusal(const std::string& text) const {
    write(text);
    return tests::refusal_of([&] { read_accounts(path_); });
  }

  tests::TemporaryFolder folder_;
  std::string path_ = folder_.file("page.accounts");
};

TEST_F(Accounts, are_lines_of_name_and_hash) {
  write("# who may command\n\nanna:" + hash + "\nnight-shift.2:" + hash + "\n");
  EXPECT_EQ(read_accounts(path_), (std::vector<Account>{{"anna", hash}, {"night-shift.2", hash}}));
}

TEST_F(Accounts, what_is_wrong_is_said_with_file_and_line) {
  const std::string known = "anna:" + hash + "\n";
  EXPECT_EQ(
      refusal(known + "bert:$2y$10$abc\n"),
      path_ + ":2: the hash of bert: must be a hash of argon2id as `spindle-twind --hash-password NAME` prints it");
  EXPECT_EQ(refusal("\n\n" + known + known), path_ + ":4: anna: stands in a line before already");
  for (const std::string& line : {std::string("anna"), "an na:" + hash, ":" + hash, "<b>:" + hash}) {
    EXPECT_EQ(refusal(known + line + "\n"),
              path_ + ":2: must be NAME:HASH, the name of 1 to 32 letters, digits, '_', '-' or '.'")
        << line;
  }
  EXPECT_EQ(refusal("# nobody\n"), path_ + ": has no line NAME:HASH: nobody could log in");
}

TEST_F(Accounts, a_file_that_everybody_reads_or_the_group_writes_is_refused) {
  for (const int mode : {0644, 0660, 0641}) {
    write("anna:" + hash + "\n", std::filesystem::perms(mode));
    EXPECT_EQ(tests::refusal_of([&] { read_accounts(path_); }),
              path_ + ": must be for its owner, and for its group to read: chmod 640")
        << mode;
  }
  std::filesystem::remove(path_);
  EXPECT_EQ(tests::refusal_of([&] { read_accounts(path_); }), path_ + ": No such file or directory");
  const std::string folder = folder_.path().string();
  EXPECT_EQ(tests::refusal_of([&] { read_accounts(folder); }), folder + ": must be a file");
}

}  // namespace login_accounts_test
}  // namespace spindle_twin::firmware
