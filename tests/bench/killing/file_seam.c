// Between a program and its files, for the tests of kills, power cuts and disks that fail: LD_PRELOAD=libfile_seam.so.
// It sees the calls that change a file of SEAM_FOLDER, strikes those that the page SEAM_PAGE asks for (a file that the
// test maps too), and tells all of them to SEAM_RECORD. Without these variables it changes nothing. The page, the
// numbers of files, calls and actions, and the record are read by seam.py. Linux with 64-bit offsets.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

enum Files { of_checkpoint = 1, of_orders = 2, of_parameters = 4, of_history = 8, of_thread = 256 };
enum Call { opens = 1, writes = 2, syncs = 4, renames = 8, removes = 16, resizes = 32, changes_mode = 64 };
enum Action { passes = 0, kills_before = 1, kills_within = 2, kills_after = 3, fails = 4, fills = 5 };

// Calls are counted where files and calls match; those from `from` to `until` are struck.
struct Page {
  _Atomic uint64_t matched, from, until, files, calls, action, error, struck;
};

enum { most_descriptors = 4096 };
static struct Page* page;
static const char* folder;
static int record = -1;
static _Atomic int watched[most_descriptors];  // enum Files by descriptor
static _Thread_local int last_files;           // the folder is synced for what this thread wrote last
static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER;

__attribute__((constructor)) static void begin(void) {
  const char* page_path = getenv("SEAM_PAGE");
  const char* record_path = getenv("SEAM_RECORD");
  folder = getenv("SEAM_FOLDER");
  unsetenv("LD_PRELOAD");
  if (folder == NULL || page_path == NULL) return;
  const int file = (int)syscall(SYS_openat, AT_FDCWD, page_path, O_RDWR | O_CLOEXEC, 0);
  void* mapped = mmap(NULL, sizeof(struct Page), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (file < 0 || mapped == MAP_FAILED) abort();
  page = mapped;
  if (record_path == NULL) return;
  record = (int)syscall(SYS_openat, AT_FDCWD, record_path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (record < 0) abort();
}

static int files_of(const char* path) {
  if (page == NULL || path == NULL) return 0;
  const size_t length = strlen(folder);
  if (strncmp(path, folder, length) != 0) return 0;
  if (path[length] == '\0') return of_thread;
  const char* name = strrchr(path, '/') + 1;
  const size_t end = strlen(name);
  if (end > 5 && strcmp(name + end - 5, ".lock") == 0) return 0;
  if (strncmp(name, "twin.checkpoint.orders", 22) == 0) return of_orders;
  if (strncmp(name, "twin.checkpoint", 15) == 0) return of_checkpoint;
  if (strncmp(name, "parameters", 10) == 0) return of_parameters;
  return strncmp(name, "history", 7) == 0 && strstr(name, "-shm") == NULL ? of_history : 0;
}

static int files_behind(int file) { return file >= 0 && file < most_descriptors ? watched[file] : 0; }

static void die(void) {
  syscall(SYS_kill, getpid(), SIGKILL);
  for (;;) pause();
}

// What is to become of this call; of `fails` errno is set.
static enum Action strike(int files, enum Call call) {
  if (files == of_thread) files = last_files;
  last_files = files;
  if ((page->files & (uint64_t)files) == 0 || (page->calls & (uint64_t)call) == 0) return passes;
  const uint64_t number = atomic_fetch_add(&page->matched, 1) + 1;
  const enum Action action = (enum Action)page->action;
  if (action == passes || number < page->from || number > page->until) return passes;
  const uint64_t struck = atomic_fetch_add(&page->struck, 1) + 1;
  if (action == kills_before) die();
  if (action == fills && call == writes && struck == 1) return fills;
  if (action != fails && action != fills) return action;
  errno = (int)page->error;
  return fails;
}

static void put_whole(const void* data, size_t size) {
  const char* at = data;
  while (size > 0) {
    const long written = syscall(SYS_write, record, at, size);
    if (written <= 0) abort();
    at += written;
    size -= (size_t)written;
  }
}

struct Told {
  int64_t call, file, number, path_bytes, other_bytes, data_bytes;
};

// `number`: flags of an opening, offset of a writing, a new size.
static void tell(struct Told told, const char* path, const char* other, const void* data) {
  if (record < 0) return;
  told.path_bytes = path == NULL ? 0 : (int64_t)strlen(path);
  told.other_bytes = other == NULL ? 0 : (int64_t)strlen(other);
  put_whole(&told, sizeof told);
  put_whole(path, (size_t)told.path_bytes);
  put_whole(other, (size_t)told.other_bytes);
  put_whole(data, (size_t)told.data_bytes);
}

// The end of a call that took its turn.
static long done(enum Action action, long result, struct Told told, const char* path, const char* other) {
  const int reason = errno;
  if (action == kills_within || action == kills_after) die();
  if (result >= 0) tell(told, path, other, NULL);
  pthread_mutex_unlock(&turn);
  errno = reason;
  return result;
}

static enum Action take_turn(int files, enum Call call) {
  pthread_mutex_lock(&turn);
  return strike(files, call);
}

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  const int files = files_of(path);
  const int only_reads = (flags & O_ACCMODE) == O_RDONLY && files != of_thread;  // the folder is opened to be synced
  if (files == 0 || only_reads) return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
  const enum Action action = take_turn(files, opens);
  const int file = action == fails ? -1 : (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
  if (file >= 0 && file < most_descriptors) watched[file] = files;
  return (int)done(action, file, (struct Told){opens, file, flags, 0, 0, 0}, path, NULL);
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));

int mkostemp(char* name, int flags) {
  int (*real)(char*, int) = NULL;
  *(void**)&real = dlsym(RTLD_NEXT, "mkostemp");
  const int files = files_of(name);
  if (files == 0) return real(name, flags);
  const enum Action action = take_turn(files, opens);
  const int file = action == fails ? -1 : real(name, flags);
  if (file >= 0 && file < most_descriptors) watched[file] = files;
  return (int)done(action, file, (struct Told){opens, file, O_RDWR | O_CREAT | O_EXCL, 0, 0, 0}, name, NULL);
}

int close(int file) {
  if (file >= 0 && file < most_descriptors) watched[file] = 0;
  return (int)syscall(SYS_close, file);
}

static ssize_t put(int file, const void* data, size_t size, off_t offset) {
  const int is_placed = offset >= 0;
  const int files = files_behind(file);
  if (files != 0) {
    const enum Action action = take_turn(files, writes);
    if (action == fails) return done(action, -1, (struct Told){0}, NULL, NULL);
    if (action == kills_within || action == fills) size = (size + 1) / 2;
    const int64_t at = is_placed ? offset : (int64_t)syscall(SYS_lseek, file, 0, SEEK_CUR);
    const long written = is_placed ? syscall(SYS_pwrite64, file, data, size, offset) : syscall(SYS_write, file, data, size);
    const int reason = errno;
    if (action == kills_within || action == kills_after) die();
    if (written >= 0) tell((struct Told){writes, file, at, 0, 0, written}, NULL, NULL, data);
    pthread_mutex_unlock(&turn);
    errno = reason;
    return written;
  }
  return is_placed ? syscall(SYS_pwrite64, file, data, size, offset) : syscall(SYS_write, file, data, size);
}

ssize_t write(int file, const void* data, size_t size) { return put(file, data, size, -1); }
ssize_t pwrite(int file, const void* data, size_t size, off_t offset) { return put(file, data, size, offset); }
ssize_t pwrite64(int file, const void* data, size_t size, off64_t offset) { return put(file, data, size, offset); }

static int on_file(enum Call call, int file, int64_t number, long which, long argument) {
  const int files = files_behind(file);
  if (files == 0) return (int)syscall(which, file, argument);
  const enum Action action = take_turn(files, call);
  const long result = action == fails ? -1 : syscall(which, file, argument);
  return (int)done(action, result, (struct Told){call, file, number, 0, 0, 0}, NULL, NULL);
}

int fsync(int file) { return on_file(syncs, file, 0, SYS_fsync, 0); }
int fdatasync(int file) { return on_file(syncs, file, 0, SYS_fdatasync, 0); }
int fchmod(int file, mode_t mode) { return on_file(changes_mode, file, mode, SYS_fchmod, (long)mode); }
int ftruncate(int file, off_t size) { return on_file(resizes, file, size, SYS_ftruncate, size); }
int ftruncate64(int file, off64_t size) { return on_file(resizes, file, size, SYS_ftruncate, size); }

int rename(const char* from, const char* to) {
  const int files = files_of(to);
  const enum Action action = files == 0 ? passes : take_turn(files, renames);
  const long result = action == fails ? -1 : syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
  return (int)(files == 0 ? result : done(action, result, (struct Told){renames, -1, 0, 0, 0, 0}, from, to));
}

int unlink(const char* path) {
  const int files = files_of(path);
  const enum Action action = files == 0 ? passes : take_turn(files, removes);
  const long result = action == fails ? -1 : syscall(SYS_unlinkat, AT_FDCWD, path, 0);
  return (int)(files == 0 ? result : done(action, result, (struct Told){removes, -1, 0, 0, 0, 0}, path, NULL));
}

int remove(const char* path) {
  const int result = unlink(path);
  return result != 0 && errno == EISDIR ? rmdir(path) : result;
}
