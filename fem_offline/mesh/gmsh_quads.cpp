#include "fem_offline/mesh/gmsh_quads.hpp"

#include <gmsh.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <sstream>
#include <unordered_map>

#include "fem_offline/mesh/rim.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr unsigned waiting_factor = 30;  // on a computer busy with other things
/// gmsh pairs some 40 000 elements per second.
constexpr double most_gmsh_elements = 1.5e5;

/// Points and quadrilaterals as they come through the pipe.
struct PartMesh {
  std::vector<double> coordinates_m;  // r, z per point
  std::vector<std::size_t> corners;   // four per element, counter-clockwise
};

int add_loop(const std::vector<RimSide>& ring) {
  std::vector<int> points, lines;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const RimSide& before = ring[(i + ring.size() - 1) % ring.size()];
    const Point& at = ring[i].start;
    // Sizes are halved by the subdivision.
    points.push_back(gmsh::model::geo::addPoint(at.r_m, at.z_m, 0.0, 2.0 * std::min(before.size_m, ring[i].size_m)));
  }
  for (std::size_t i = 0; i < ring.size(); ++i) {
    lines.push_back(gmsh::model::geo::addLine(points[i], points[(i + 1) % ring.size()]));
    const double length_m = std::hypot(ring[i].end.r_m - ring[i].start.r_m, ring[i].end.z_m - ring[i].start.z_m);
    const int divisions = std::max(1, static_cast<int>(std::ceil(length_m / (2.0 * ring[i].size_m) - 1e-6)));
    gmsh::model::geo::mesh::setTransfiniteCurve(lines.back(), divisions + 1);
  }
  return gmsh::model::geo::addCurveLoop(lines);
}

PartMesh copied_quads() {
  constexpr int quadrilateral = 3;
  std::vector<std::size_t> tags, element_tags, element_nodes;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  gmsh::model::mesh::getElementsByType(quadrilateral, element_tags, element_nodes);
  std::unordered_map<std::size_t, std::size_t> position_of_tag, known;
  for (std::size_t i = 0; i < tags.size(); ++i) position_of_tag[tags[i]] = i;
  PartMesh mesh;
  const auto point = [&](std::size_t tag) {
    const auto [entry, is_new] = known.try_emplace(tag, mesh.coordinates_m.size() / 2);
    const std::size_t at = position_of_tag.at(tag);
    if (is_new) mesh.coordinates_m.insert(mesh.coordinates_m.end(), {coordinates[3 * at], coordinates[3 * at + 1]});
    return entry->second;
  };
  for (std::size_t e = 0; e < element_tags.size(); ++e) {
    std::array<std::size_t, 4> quad{};
    for (std::size_t k = 0; k < 4; ++k) quad[k] = point(element_nodes[4 * e + k]);
    double twice_area = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const double* a = &mesh.coordinates_m[2 * quad[k]];
      const double* b = &mesh.coordinates_m[2 * quad[(k + 1) % 4]];
      twice_area += a[0] * b[1] - b[0] * a[1];
    }
    if (twice_area < 0.0) std::swap(quad[1], quad[3]);
    mesh.corners.insert(mesh.corners.end(), quad.begin(), quad.end());
  }
  return mesh;
}

PartMesh meshed(const std::vector<Rim>& faces) {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::option::setNumber("General.NumThreads", 1);
  // Algorithm 8 of gmsh 4.8.4 crashes. Frontal triangles, paired where possible and then split in 3 or 4, give
  // quadrilaterals only.
  gmsh::option::setNumber("Mesh.Algorithm", 6);
  gmsh::option::setNumber("Mesh.RecombinationAlgorithm", 1);
  gmsh::option::setNumber("Mesh.SubdivisionAlgorithm", 1);
  gmsh::model::add("part");
  for (const Rim& rim : faces) {
    std::vector<int> loops;
    for (const auto& ring : rim) loops.push_back(add_loop(ring));
    gmsh::model::geo::mesh::setRecombine(2, gmsh::model::geo::addPlaneSurface(loops));
  }
  gmsh::model::geo::synchronize();
  gmsh::model::mesh::generate(2);
  return copied_quads();
}

bool write_all(int pipe_end, const void* data, std::size_t bytes) {
  const char* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = ::write(pipe_end, from, bytes);
    if (written <= 0) return false;
    from += written;
    bytes -= static_cast<std::size_t>(written);
  }
  return true;
}

bool read_all(int pipe_end, void* data, std::size_t bytes) {
  char* to = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = ::read(pipe_end, to, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

/// In the child: sends sizes and content; empty content with a message when gmsh threw.
[[noreturn]] void mesh_and_send(const std::vector<Rim>& faces, unsigned longest_computing_s, int pipe_end) {
  // The parent may have handlers of its own; here these signals just end the process.
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGALRM, SIGXCPU}) ::signal(signal, SIG_DFL);
  const rlimit computing{longest_computing_s, longest_computing_s + 1};
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CPU, &computing);
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::alarm(waiting_factor * longest_computing_s);
  PartMesh mesh;
  std::string message;
  try {
    mesh = meshed(faces);
  } catch (const std::exception& error) {
    message = error.what();
    if (message.empty()) message = "no reason given";
  } catch (...) {  // gmsh throws integers too
    message = "no reason given";
  }
  const std::size_t sizes[3] = {message.size(), mesh.coordinates_m.size(), mesh.corners.size()};
  const bool sent = write_all(pipe_end, sizes, sizeof sizes) && write_all(pipe_end, message.data(), sizes[0]) &&
                    write_all(pipe_end, mesh.coordinates_m.data(), sizes[1] * sizeof(double)) &&
                    write_all(pipe_end, mesh.corners.data(), sizes[2] * sizeof(std::size_t));
  ::_exit(sent ? 0 : 1);
}

/// Runs gmsh in a process of its own: it is one global state, and a wild outline can crash it or keep it busy for ever.
/// Returns what went wrong, empty if nothing did.
std::string mesh_apart(const std::vector<Rim>& faces, unsigned longest_computing_s, PartMesh& mesh) {
  int ends[2];
  if (::pipe(ends) != 0) return "no pipe can be made";
  std::fflush(nullptr);  // gmsh flushes stdout, and with it what the parent had written into its copy of the buffer
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return "no process can be started";
  }
  if (child == 0) {
    ::close(ends[0]);
    mesh_and_send(faces, longest_computing_s, ends[1]);
  }
  ::close(ends[1]);
  std::size_t sizes[3] = {0, 0, 0};
  std::string message;
  bool received = read_all(ends[0], sizes, sizeof sizes);
  if (received) {
    message.resize(sizes[0]);
    mesh.coordinates_m.resize(sizes[1]);
    mesh.corners.resize(sizes[2]);
    received = read_all(ends[0], message.data(), sizes[0]) &&
               read_all(ends[0], mesh.coordinates_m.data(), sizes[1] * sizeof(double)) &&
               read_all(ends[0], mesh.corners.data(), sizes[2] * sizeof(std::size_t));
  }
  ::close(ends[0]);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (received && message.empty() && mesh.corners.empty()) return "it made no element";
  if (received) return message;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (signal == SIGXCPU || signal == SIGKILL || signal == SIGALRM) {
      return "it did not finish in " + std::to_string(longest_computing_s) +
             " s of computing; raise element_size_mm or mesh.part_time_limit_s";
    }
    return "it crashed (signal " + std::to_string(signal) + ")";
  }
  return "it stopped without a result";
}

double area_m2(const OutlineFace& face) {
  double area = volume_within(face.outer, Geometry::planar);
  for (const Polygon& hole : face.holes) area += volume_within(hole, Geometry::planar);
  return area;
}

/// Elements to come: area over the mean size along the rim squared, for gmsh interpolates sizes inwards from there, and
/// a band of some rows along finer sides.
double expected_elements(const OutlineFace& face, const Rim& rim) {
  constexpr double rows = 4.0;
  double length_m = 0.0, length_by_size_m2 = 0.0, along_rim = 0.0;
  for (const auto& ring : rim) {
    for (const RimSide& side : ring) {
      const double side_m = std::hypot(side.end.r_m - side.start.r_m, side.end.z_m - side.start.z_m);
      length_m += side_m;
      length_by_size_m2 += side_m * side.size_m;
      along_rim += side_m / side.size_m;
    }
  }
  const double mean_size_m = length_by_size_m2 / length_m;
  return area_m2(face) / (mean_size_m * mean_size_m) + rows * along_rim;
}

}  // namespace

void add_gmsh_quads(const Spindle& spindle, const Section& section, std::size_t part, double element_limit,
                    SectionMesh& mesh) {
  const Part& named = spindle.parts[part];
  std::vector<Rim> faces;
  double elements = 0.0;
  for (const OutlineFace& face : section.outlines[part].faces) {
    faces.push_back(make_rim(spindle, section, part, face));
    elements += expected_elements(face, faces.back());
  }
  const double most = std::min(element_limit, most_gmsh_elements);
  if (elements > most) {
    std::ostringstream message;
    message << "its element sizes would cut this part into " << elements << " elements, at most " << most
            << " are allowed for a part with slanted sides: raise its element_size_mm";
    throw rom::InputError(named.where, "part." + named.name, message.str());
  }
  PartMesh made;
  const auto limit_s = static_cast<unsigned>(spindle.mesh.part_time_limit_s);
  const std::string failure = mesh_apart(faces, limit_s, made);
  if (!failure.empty()) {
    throw rom::InputError(named.where, "part." + named.name, "gmsh could not mesh this part: " + failure);
  }
  const std::size_t first_point = mesh.points.size();
  for (std::size_t i = 0; i + 1 < made.coordinates_m.size(); i += 2) {
    mesh.points.push_back({made.coordinates_m[i], made.coordinates_m[i + 1]});
  }
  for (std::size_t i = 0; i + 3 < made.corners.size(); i += 4) {
    mesh.quads.push_back({first_point + made.corners[i], first_point + made.corners[i + 1],
                          first_point + made.corners[i + 2], first_point + made.corners[i + 3]});
    mesh.part_of_quad.push_back(part);
  }
}

}  // namespace spindle_twin::fem_offline
