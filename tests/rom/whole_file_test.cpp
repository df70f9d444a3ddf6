#include "rom/file/whole_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/ucontext.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::rom::tests {
namespace whole_file_test {

using spindle_twin::tests::refusal_of;

namespace fs = std::filesystem;

std::string text_of(const std::string& path) {
  const std::vector<std::uint8_t> bytes = read_whole_file(path, 1U << 20U);
  return {bytes.begin(), bytes.end()};
}

mode_t mode_of(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? status.st_mode & 07777U : 0;
}

/// Whether the call says so in a process of its own, which changes its descriptors, limits and folder for itself alone
/// and is ended after 10 s.
bool in_child(const std::function<bool()>& call) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(10);
    bool good = false;
    try {
      good = call();
    } catch (const std::exception&) {
    }
    ::_exit(good ? 0 : 1);
  }
  int status = 0;
  return child > 0 && ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

class WholeFile : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder.file(name); }

  /// All kinds that a path may be beside a file. None is a device of the machine: a test with a fault in it would
  /// replace that. The device needs root.
  std::vector<std::string> of_other_kinds() const {
    std::vector<std::string> paths{file("folder"), file("pipe"), file("socket")};
    fs::create_directory(paths[0]);
    EXPECT_EQ(::mkfifo(paths[1].c_str(), 0600), 0);
    sockaddr_un here{};
    here.sun_family = AF_UNIX;
    std::strncpy(here.sun_path, paths[2].c_str(), sizeof here.sun_path - 1);
    const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&here), sizeof here), 0);
    ::close(socket);
    const std::string device = file("device");
    if (::mknod(device.c_str(), S_IFCHR | 0600, ::makedev(1, 5)) == 0) paths.push_back(device);
    return paths;
  }

  spindle_twin::tests::TemporaryFolder folder;
};

TEST_F(WholeFile, says_what_was_written_to_the_bit) {
  std::vector<std::uint8_t> bytes(300000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i / 7);
  write_whole_file(file("x"), bytes);
  EXPECT_EQ(read_whole_file(file("x"), bytes.size()), bytes);
  write_whole_file(file("empty"), std::string());
  EXPECT_TRUE(read_whole_file(file("empty"), 0).empty());
  write_private_file(file("own"), std::string("a\0b", 3));
  EXPECT_EQ(text_of(file("own")), std::string("a\0b", 3));
  EXPECT_EQ(folder.files(), 3) << "something unfinished is left";
}

TEST_F(WholeFile, replaces_the_old_one_and_respects_the_bound) {
  write_whole_file(file("x"), std::string("first, longer"));
  write_whole_file(file("x"), std::string("second"));
  EXPECT_EQ(read_whole_file(file("x"), 6).size(), 6U);
  EXPECT_EQ(text_of(file("x")), "second");
  EXPECT_EQ(refusal_of([&] { read_whole_file(file("x"), 5); }), file("x") + ": 6 bytes; at most 5 are allowed");
  EXPECT_EQ(folder.files(), 1);
}

TEST_F(WholeFile, a_missing_file_is_refused_with_the_reason) {
  EXPECT_EQ(refusal_of([&] { read_whole_file(file("x"), 10); }),
            file("x") + ": cannot be opened for reading: No such file or directory");
  const std::string nowhere = file("no/x");
  EXPECT_EQ(refusal_of([&] { write_whole_file(nowhere, std::string("x")); }),
            nowhere + ": cannot be written: No such file or directory");
  EXPECT_EQ(refusal_of([&] { write_private_file(nowhere, "x"); }),
            nowhere + ": cannot be written: No such file or directory");
  EXPECT_EQ(refusal_of([&] { check_writable(nowhere, "output"); }),
            nowhere + ": output: cannot be written: No such file or directory");
  EXPECT_EQ(refusal_of([&] { make_folder_beside(nowhere, "output"); }),
            nowhere + ": output: no folder can be made: No such file or directory");
  EXPECT_EQ(folder.files(), 0);
}

/// Also a pipe that nobody writes to: reading must not wait for somebody who does.
TEST_F(WholeFile, folder_pipe_socket_and_device_are_neither_read_nor_replaced) {
  for (const std::string& path : of_other_kinds()) {
    const fs::file_type kind = fs::status(path).type();
    EXPECT_TRUE(in_child([&] { return refusal_of([&] { read_whole_file(path, 1U << 20U); }) != "accepted"; })) << path;
    EXPECT_EQ(refusal_of([&] { write_whole_file(path, std::string("x")); }),
              path + ": cannot be written: it exists and is not a regular file");
    EXPECT_EQ(refusal_of([&] { check_writable(path, "output"); }),
              path + ": output: cannot be written: it exists and is not a regular file");
    EXPECT_EQ(fs::status(path).type(), kind) << path << " was replaced";
  }
  EXPECT_EQ(refusal_of([&] { read_whole_file(file("folder"), 10); }), file("folder") + ": is not a regular file");
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    EXPECT_EQ(entry.path().string().find(unfinished_mark), std::string::npos) << entry.path();
  }
}

/// A file may grow to 4096 bytes: the first write takes a part, the next one none.
TEST_F(WholeFile, a_write_that_fails_leaves_the_old_file_and_nothing_unfinished) {
  write_whole_file(file("x"), std::string("old"));
  for (const bool is_private : {false, true}) {
    EXPECT_TRUE(in_child([&] {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{4096, 4096};
      ::setrlimit(RLIMIT_FSIZE, &limit);
      const std::string path = file(is_private ? "own" : "x"), text(10000, 'n');
      const std::string said =
          refusal_of([&] { is_private ? write_private_file(path, text) : write_whole_file(path, text); });
      return said == path + ": cannot be written: File too large";
    }));
  }
  EXPECT_EQ(text_of(file("x")), "old");
  EXPECT_EQ(folder.files(), 1);
}

#if defined(__x86_64__)
/// Lets the file grow by another 1000 bytes and says that the write was interrupted, as a signal's handler may find it.
void grow_and_interrupt(int, siginfo_t*, void* context) {
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur += 1000;
  ::setrlimit(RLIMIT_FSIZE, &limit);
  static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RAX] = -EINTR;
}

/// A file may grow to 1000 bytes: the first write takes a part and the next one is interrupted, and so on.
TEST_F(WholeFile, a_write_that_takes_a_part_or_is_interrupted_goes_on_where_it_ended) {
  std::string text;
  for (int i = 0; text.size() < 4500; ++i) text += std::to_string(i) + " ";
  EXPECT_TRUE(in_child([&] {
    struct sigaction action {};
    action.sa_sigaction = grow_and_interrupt;
    action.sa_flags = SA_SIGINFO;
    ::sigaction(SIGXFSZ, &action, nullptr);
    const rlimit limit{1000, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    write_whole_file(file("x"), text);
    return true;
  }));
  EXPECT_EQ(text_of(file("x")), text);
}
#endif

/// The kernel gives this one a page at a time.
TEST_F(WholeFile, a_file_that_is_read_in_parts_is_whole) {
  const std::string path = "/sys/kernel/btf/vmlinux";
  if (!fs::exists(path)) GTEST_SKIP() << "this kernel has no " << path;
  std::ifstream stream(path, std::ios::binary);
  const std::vector<std::uint8_t> whole{std::istreambuf_iterator<char>(stream), {}};
  const std::vector<std::uint8_t> read = read_whole_file(path, whole.size());
  ASSERT_EQ(read.size(), whole.size());
  EXPECT_TRUE(read == whole);
}

/// A file that says of itself that it is longer than what it gives.
TEST_F(WholeFile, a_file_that_was_cut_short_while_it_was_read_ends_there) {
  const std::string path = "/sys/kernel/mm/transparent_hugepage/enabled";
  if (!fs::exists(path)) GTEST_SKIP() << "this kernel has no " << path;
  std::ifstream stream(path);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  ASSERT_LT(whole.size(), fs::file_size(path));
  EXPECT_TRUE(in_child([&] {
    errno = EINTR;  // of a call before: a read that ends the file leaves it
    return text_of(path) == whole;
  }));
}

/// A system call that the kernel answers with an error from now on, where the bits `mask` of an argument are `value`.
struct FailingCall {
  long call = 0;
  int error = EIO;
  std::uint32_t argument = 0, mask = 0, value = 0;
};

bool make_fail(const FailingCall& failing) {
  const auto number = [](std::size_t at) { return static_cast<std::uint32_t>(at); };
  const std::uint32_t argument_at = number(offsetof(seccomp_data, args)) + 8 * failing.argument;  // its lower half
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, number(offsetof(seccomp_data, nr))),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(failing.call), 0, 4),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, argument_at),
      BPF_STMT(BPF_ALU | BPF_AND | BPF_K, failing.mask),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, failing.value, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(failing.error)),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{static_cast<unsigned short>(std::size(filter)), filter};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

/// Of a file, of its mode, of its folder, and of what is read.
TEST_F(WholeFile, a_disk_that_fails_at_one_call_is_told_by_that_call) {
  if (!in_child([] { return make_fail({SYS_fsync, EIO, 0, 0xffffffffU, 99}); })) GTEST_SKIP() << "no seccomp here";
  write_whole_file(file("x"), std::string("old"));
  const auto said = [&](const FailingCall& failing, const std::string& expected) {
    return in_child([&] {
      const std::string path = file("x");
      return make_fail(failing) && refusal_of([&] { write_whole_file(path, std::string("new")); }) == path + expected;
    });
  };
  EXPECT_TRUE(said({SYS_fsync}, ": cannot be written: Input/output error"));
  EXPECT_TRUE(said({SYS_fchmod, EPERM}, ": cannot be written: Operation not permitted"));
  EXPECT_EQ(text_of(file("x")), "old");
  EXPECT_EQ(folder.files(), 1);
  const int of_file = ::open("/", O_RDONLY), of_folder = ::open("/", O_RDONLY);  // the next two that are free
  ::close(of_file);
  ::close(of_folder);
  EXPECT_TRUE(said({SYS_fsync, EIO, 0, 0xffffffffU, static_cast<std::uint32_t>(of_folder)},
                   ": its folder cannot be synced: Input/output error"));
  EXPECT_TRUE(
      said({SYS_openat, EACCES, 2, O_DIRECTORY, O_DIRECTORY}, ": its folder cannot be synced: Permission denied"));
  EXPECT_TRUE(in_child([&] {
    return make_fail({SYS_read}) &&
           refusal_of([&] { read_whole_file(file("x"), 10); }) == file("x") + ": cannot be read: Input/output error";
  }));
}

TEST_F(WholeFile, permissions_are_0644_less_the_umask_and_of_a_private_one_0600) {
  for (const mode_t mask : {0U, 022U, 027U, 077U}) {
    const mode_t before = ::umask(mask);
    write_whole_file(file("x"), std::string("x"));
    ::unlink(file("own").c_str());
    write_private_file(file("own"), "x");
    EXPECT_EQ(::umask(before), mask) << "the umask is the caller's";
    EXPECT_EQ(mode_of(file("x")), 0644U & ~mask);
    EXPECT_EQ(mode_of(file("own")), 0600U);
  }
}

TEST_F(WholeFile, a_private_one_never_replaces) {
  write_whole_file(file("own"), std::string("first"));
  EXPECT_EQ(refusal_of([&] { write_private_file(file("own"), "second"); }),
            file("own") + ": cannot be written: File exists");
  EXPECT_EQ(text_of(file("own")), "first");
  EXPECT_EQ(folder.files(), 1);
}

TEST_F(WholeFile, asking_whether_it_can_be_written_changes_nothing) {
  check_writable(file("x"), "output");
  EXPECT_EQ(folder.files(), 0);
  write_whole_file(file("x"), std::string("old"));
  check_writable(file("x"), "output");
  EXPECT_EQ(text_of(file("x")), "old");
  EXPECT_EQ(folder.files(), 1);
}

TEST_F(WholeFile, a_new_folder_stands_beside_the_wanted_one_and_not_in_it) {
  fs::create_directory(file("out"));
  for (const std::string& wanted : {file("out"), file("out/"), file("out//")}) {
    const std::string made = make_folder_beside(wanted, "output");
    EXPECT_EQ(made.substr(0, made.size() - 6), file("out").append(unfinished_mark)) << wanted;
    EXPECT_EQ(mode_of(made), 0700U);
    EXPECT_TRUE(fs::is_empty(file("out")));
    fs::remove(made);
  }
}

TEST_F(WholeFile, a_name_without_a_folder_is_in_the_present_one) {
  EXPECT_TRUE(in_child([&] {
    fs::current_path(folder.path());
    write_whole_file("x", std::string("here"));
    return text_of("x") == "here";
  }));
  EXPECT_EQ(folder.files(), 1);
}

/// With standard input closed the next file is descriptor 0, as good as any. It is 0 again after each call: none keeps
/// one open.
TEST_F(WholeFile, descriptor_zero_serves_and_none_stays_open) {
  EXPECT_TRUE(in_child([&] {
    ::close(0);
    const auto next_is_zero = [] {
      const int next = ::open("/", O_RDONLY);
      ::close(next);
      return next == 0;
    };
    write_whole_file(file("x"), std::string("by zero"));
    bool good = next_is_zero();
    good = good && text_of(file("x")) == "by zero" && next_is_zero();
    write_private_file(file("own"), "by zero");
    good = good && next_is_zero() && text_of(file("own")) == "by zero";
    check_writable(file("y"), "output");
    good = good && next_is_zero();
    const bool refused = refusal_of([&] { read_whole_file(file("x"), 1); }) != "accepted";
    return good && refused && next_is_zero();
  }));
}

}  // namespace whole_file_test
}  // namespace spindle_twin::rom::tests
