// Shortcuts of a path with a Checker's verdicts on edges, where the interpreter is asked about those that are not sure.
#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "bind/arguments.hpp"
#include "bind/bind.hpp"
#include "checker/checker.hpp"
#include "search/cut_corners.hpp"
#include "search/relax_path.hpp"
#include "search/skip_vertices.hpp"

namespace wayproof {
namespace {

using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// Most samples, and most edges of which the first free one is sought, between two looks at the deadline.
constexpr std::int64_t most_samples = 4096;
constexpr std::size_t most_edges = 32;

template <typename Work>
auto without_lock(const Work& work) {
  nb::gil_scoped_release released;
  return work();
}

// Verdicts of a Checker, if there is one; of the interpreter, which counts its own, where that is not sure or too long.
class CheckedEdges : public EdgeVerdicts {
 public:
  CheckedEdges(const Checker* checker, int nq, double resolution, nb::callable look, nb::callable are_free,
               nb::callable first_free)
      : EdgeVerdicts(nq, resolution),
        checker_(checker),
        look_(std::move(look)),
        are_free_(std::move(are_free)),
        first_free_(std::move(first_free)) {}

  std::vector<char> are_free(const Edges& edges) override {
    const std::size_t count = edges.from.size() / nq;
    if (checker_) {
      look_();
      std::vector<Verdict> verdicts(count);
      std::vector<Unsure> unsure;
      const std::int64_t total = without_lock(
          [&] { return checker_->check_edges(edges.from, edges.to, resolution, most_samples, verdicts, unsure); });
      if (total <= most_samples && unsure.empty()) {
        num_edges += static_cast<std::int64_t>(count), num_states += total;
        std::vector<char> free(count);
        for (std::size_t i = 0; i < count; ++i) free[i] = verdicts[i] != Verdict::colliding;
        return free;
      }
    }
    const nb::object found = are_free_(rows_of(edges.from), rows_of(edges.to));
    const auto flags = nb::cast<Flags>(found);
    require(flags.shape(0) == count, "are_free does not answer for every edge");
    return {flags.data(), flags.data() + count};
  }

  std::size_t first_free(std::span<const double> from, std::span<const double> to) override {
    const std::size_t count = std::max(from.size(), to.size()) / nq;
    const auto part = [&](std::span<const double> rows, std::size_t begin, std::size_t end) {
      return rows.size() > static_cast<std::size_t>(nq) ? rows.subspan(begin * nq, (end - begin) * nq) : rows;
    };
    std::size_t index = 0;
    while (checker_ && index < count) {
      look_();
      const std::size_t end = std::min(index + most_edges, count);
      const FirstEdge found = without_lock([&] {
        return checker_->first_edge(part(from, index, end), part(to, index, end), end - index, resolution,
                                    most_samples);
      });
      num_states += found.num_samples;
      index += found.index;
      const bool is_free = found.verdict == Verdict::free;
      num_edges += static_cast<std::int64_t>(found.index + is_free);
      if (is_free) return index;
      if (found.verdict == Verdict::unsure) break;
    }
    if (index == count) return count;
    const nb::object rest = first_free_(rows_of(part(from, index, count)), rows_of(part(to, index, count)));
    const auto further = nb::cast<std::size_t>(rest);
    require(further <= count - index, "first_free names an edge that there is not");
    return index + further;
  }

  std::int64_t num_edges = 0, num_states = 0;

 private:
  nb::object rows_of(std::span<const double> rows) const {
    return nb::cast(array_of(std::vector<double>(rows.begin(), rows.end()), rows.size() / nq, nq));
  }

  const Checker* checker_;
  nb::callable look_, are_free_, first_free_;
};

void make(CheckedEdges* self, const Checker* checker, int nq, double resolution, const nb::callable& look,
          const nb::callable& are_free, const nb::callable& first_free) {
  require(nq > 0 && nq <= max_coordinates, "num_positions is not positive");
  require(!checker || checker->num_positions() == nq, "num_positions is not the checker's");
  new (self) CheckedEdges(checker, nq, positive(resolution, "resolution"), look, are_free, first_free);
}

Table path_of(const Doubles& waypoints, const CheckedEdges& edges, const char* name = "waypoints") {
  const Table rows = table(waypoints, static_cast<std::size_t>(edges.nq), name);
  require(rows.rows > 0, "a path has no waypoints");
  finite(rows.all(), name);
  return rows;
}

auto rows_of(const std::vector<double>& path, const CheckedEdges& edges) {
  return array_of(path, path.size() / edges.nq, edges.nq);
}

auto skip(CheckedEdges& edges, const Doubles& waypoints, const nb::callable& is_over) {
  const Table rows = path_of(waypoints, edges);
  return rows_of(skip_vertices(rows.all(), edges, [&] { return nb::cast<bool>(is_over()); }), edges);
}

auto tightened(CheckedEdges& edges, const Doubles& waypoints, int max_parts) {
  require(max_parts > 0, "max_parts is not positive");
  return rows_of(tighten(path_of(waypoints, edges).all(), edges, max_parts), edges);
}

auto relax(CheckedEdges& edges, const Doubles& waypoints, int max_sweeps, double min_gain, double first_whole_fraction,
           double max_whole_fraction, double growth, double shrinkage, const nb::callable& is_over) {
  const RelaxSettings settings{max_sweeps,
                               positive(min_gain, "min_gain"),
                               positive(first_whole_fraction, "first_whole_fraction"),
                               positive(max_whole_fraction, "max_whole_fraction"),
                               positive(growth, "growth"),
                               positive(shrinkage, "shrinkage")};
  const Table rows = path_of(waypoints, edges);
  return rows_of(relax_path(rows.all(), settings, edges, [&] { return nb::cast<bool>(is_over()); }), edges);
}

auto back(CheckedEdges& edges, const Doubles& waypoints, const Doubles& free_path, double first_fraction, double growth,
          double max_fraction) {
  const Table desired = path_of(waypoints, edges), free = path_of(free_path, edges, "free_path");
  require(desired.rows == free.rows, "the paths differ in their number of waypoints");
  require(growth > 1, "growth is not above 1");
  const BacktrackSettings settings{positive(first_fraction, "first_fraction"), finite(growth, "growth"),
                                   positive(max_fraction, "max_fraction")};
  return rows_of(backtrack(desired.all(), free.all(), edges, settings), edges);
}

auto cut(CheckedEdges& edges, const Doubles& waypoints, const Doubles& fractions, double min_gain) {
  const auto shares = finite(row(fractions, "fractions"), "fractions");
  const bool are_shares = std::all_of(shares.begin(), shares.end(), [](double s) { return s > 0 && s <= 1; });
  require(are_shares, "fractions are not above 0 and at most 1");
  return rows_of(cut_corners(path_of(waypoints, edges).all(), edges, shares, positive(min_gain, "min_gain")), edges);
}

}  // namespace

void bind_shortcut(nb::module_& m) {
  nb::class_<CheckedEdges>(m, "CheckedEdges", "Verdicts on the edges of paths, and how many were decided here.")
      .def("__init__", &make, nb::arg("checker").none(), nb::arg("num_positions"), nb::arg("resolution"),
           nb::arg("look"), nb::arg("are_free"), nb::arg("first_free"), nb::keep_alive<1, 2>())
      .def_ro("num_edges", &CheckedEdges::num_edges)
      .def_ro("num_states", &CheckedEdges::num_states);
  m.def("skip_vertices", &skip, nb::arg("edges"), nb::arg("waypoints"), nb::arg("is_over"));
  m.def("tighten", &tightened, nb::arg("edges"), nb::arg("waypoints"), nb::arg("max_parts"));
  m.def("relax_path", &relax, nb::arg("edges"), nb::arg("waypoints"), nb::arg("max_sweeps"), nb::arg("min_gain"),
        nb::arg("first_whole_fraction"), nb::arg("max_whole_fraction"), nb::arg("growth"), nb::arg("shrinkage"),
        nb::arg("is_over"));
  m.def("backtrack", &back, nb::arg("edges"), nb::arg("waypoints"), nb::arg("free_path"), nb::arg("first_fraction"),
        nb::arg("growth"), nb::arg("max_fraction"));
  m.def("cut_corners", &cut, nb::arg("edges"), nb::arg("waypoints"), nb::arg("fractions"), nb::arg("min_gain"));
}

}  // namespace wayproof
