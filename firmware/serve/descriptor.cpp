#include "firmware/serve/descriptor.hpp"

#include <unistd.h>

namespace spindle_twin::firmware {

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Descriptor::~Descriptor() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace spindle_twin::firmware
