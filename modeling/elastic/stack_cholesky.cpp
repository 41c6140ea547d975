#include "modeling/elastic/stack_cholesky.h"

#include <algorithm>
#include <cstdint>

#include "fitting/front_kernels.h"

namespace annulus {
namespace {

std::size_t RoundUp(std::size_t n) { return (n + kFrontLanes - 1) / kFrontLanes * kFrontLanes; }
std::size_t PanelStride(const StackNode& node) { return RoundUp(node.own_count + node.boundary_count) + kFrontLanes; }
std::size_t RestStride(const StackNode& node) { return RoundUp(node.boundary_count) + kFrontLanes; }

/// A front: its first columns go to the factor, the rest to the parent. Local index: own first, then boundary.
struct Front {
  double* panel = nullptr;
  std::size_t panel_stride = 0;
  std::size_t own = 0;
  double* rest = nullptr;
  std::size_t rest_stride = 0;

  /// The column whose element `row` is at [row], for rows >= column.
  [[nodiscard]] double* Column(std::size_t column) const {
    return column < own ? panel + column * panel_stride : rest + (column - own) * rest_stride - own;
  }
};

/// Where each stack's first unknown stands in the front at hand.
class FrontPlaces {
 public:
  explicit FrontPlaces(const StackTree& tree) : tree_(tree), place_(tree.shape().stacks(), 0) {}

  void Enter(const StackNode& node) {
    std::size_t next = 0;
    for (const auto* stacks : {&node.own, &node.boundary}) {
      for (const std::uint32_t stack : *stacks) {
        place_[stack] = next;
        next += tree_.Free(stack).size();
      }
    }
  }
  [[nodiscard]] std::size_t operator[](std::size_t stack) const { return place_[stack]; }

 private:
  const StackTree& tree_;
  std::vector<std::size_t> place_;
};

/// Adds the lower part of a child's Schur complement.
void AddChild(const StackTree& tree, const StackNode& child, const double* rest, const FrontPlaces& places,
              const Front& front) {
  const std::size_t stride = RestStride(child);
  const std::vector<std::uint32_t>& stacks = child.boundary;
  std::size_t from_column = 0;
  for (std::size_t b = 0; b < stacks.size(); ++b) {
    const std::size_t width = tree.Free(stacks[b]).size();
    for (std::size_t c = 0; c < width; ++c, ++from_column) {
      double* column = front.Column(places[stacks[b]] + c);
      const double* from = rest + from_column * stride + from_column;
      std::size_t skip = c;  // of the first stack only what lies below the diagonal
      for (std::size_t a = b; a < stacks.size(); ++a) {
        double* to = column + places[stacks[a]];
        const std::size_t height = tree.Free(stacks[a]).size();
        for (std::size_t r = skip; r < height; ++r) to[r] += *from++;
        skip = 0;
      }
    }
  }
}

/// Adds the lower part of a pile's matrix.
class PileAdder {
 public:
  explicit PileAdder(const StackTree& tree) : tree_(tree), per_stack_(3 * tree.shape().layers) {}

  void Add(std::size_t pile, const double* matrix, const FrontPlaces& places, const Front& front) {
    entries_.clear();
    const std::array<std::size_t, 4> stacks = tree_.shape().StacksOf(pile);
    for (std::size_t s = 0; s < 4; ++s) {
      const std::vector<std::uint16_t>& free = tree_.Free(stacks[s]);
      for (std::size_t k = 0; k < free.size(); ++k) {
        entries_.push_back({places[stacks[s]] + k, s * per_stack_ + free[k]});
      }
    }
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.front < b.front; });
    const std::size_t stride = 4 * per_stack_;
    for (std::size_t b = 0; b < entries_.size(); ++b) {
      double* column = front.Column(entries_[b].front);
      const double* from = matrix + entries_[b].pile * stride;
      for (std::size_t a = b; a < entries_.size(); ++a) column[entries_[a].front] += from[entries_[a].pile];
    }
  }

 private:
  struct Entry {
    std::size_t front;
    std::size_t pile;
  };
  const StackTree& tree_;
  std::size_t per_stack_;
  std::vector<Entry> entries_;
};

using Panel = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

}  // namespace

StackCholesky::StackCholesky(std::shared_ptr<const StackTree> tree) : tree_(std::move(tree)) {
  std::size_t total = 0;
  for (const StackNode& node : tree_->nodes()) {
    panel_first_.push_back(total);
    total += PanelStride(node) * node.own_count;
  }
  panels_.assign(total + kFrontLanes, 0.0);
}

bool StackCholesky::Eliminate(const PileMatrix& pile_matrix) {
  FrontPlaces places(*tree_);
  PileAdder piles(*tree_);
  const std::vector<StackNode>& nodes = tree_->nodes();
  std::vector<std::vector<double>> rests(nodes.size());  // Schur complements that wait for their parents
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const StackNode& node = nodes[n];
    rests[n].assign(RestStride(node) * node.boundary_count + kFrontLanes, 0.0);
    const Front front{panels_.data() + panel_first_[n], PanelStride(node), node.own_count, rests[n].data(),
                      RestStride(node)};
    places.Enter(node);
    for (const std::uint32_t pile : node.piles) piles.Add(pile, pile_matrix(pile), places, front);
    for (const std::uint32_t child : node.children) {
      AddChild(*tree_, nodes[child], rests[child].data(), places, front);
      rests[child] = {};
    }
    if (!EliminateFront(front.panel, front.panel_stride, node.own_count + node.boundary_count, node.own_count,
                        front.rest, front.rest_stride)) {
      return false;
    }
  }
  return true;
}

std::optional<StackCholesky> StackCholesky::Factor(std::shared_ptr<const StackTree> tree,
                                                   const PileMatrix& pile_matrix) {
  StackCholesky factor(std::move(tree));
  if (!factor.Eliminate(pile_matrix)) return std::nullopt;
  return factor;
}

Eigen::MatrixXd StackCholesky::Solve(const Eigen::MatrixXd& right) const {
  const std::vector<StackNode>& nodes = tree_->nodes();
  const auto size = static_cast<Eigen::Index>(tree_->size());
  Eigen::MatrixXd x(size, right.cols());
  for (Eigen::Index k = 0; k < size; ++k) x.row(k) = right.row(tree_->component()[static_cast<std::size_t>(k)]);
  Eigen::MatrixXd at_boundary;
  const auto each_boundary = [&](const StackNode& node, const auto& visit) {
    Eigen::Index place = 0;
    for (const std::uint32_t stack : node.boundary) {
      const auto count = static_cast<Eigen::Index>(tree_->Free(stack).size());
      visit(static_cast<Eigen::Index>(tree_->Position(stack)), place, count);
      place += count;
    }
  };
  const auto panel_of = [&](std::size_t n) {
    const auto own = static_cast<Eigen::Index>(nodes[n].own_count);
    return Panel(panels_.data() + panel_first_[n], own + static_cast<Eigen::Index>(nodes[n].boundary_count), own,
                 Eigen::OuterStride<>(static_cast<Eigen::Index>(PanelStride(nodes[n]))));
  };
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (nodes[n].own_count == 0) continue;
    const Panel panel = panel_of(n);
    auto inside = x.middleRows(static_cast<Eigen::Index>(nodes[n].first), panel.cols());
    panel.topRows(panel.cols()).triangularView<Eigen::Lower>().solveInPlace(inside);
    at_boundary.noalias() = panel.bottomRows(panel.rows() - panel.cols()) * inside;
    each_boundary(nodes[n], [&](Eigen::Index position, Eigen::Index place, Eigen::Index count) {
      x.middleRows(position, count) -= at_boundary.middleRows(place, count);
    });
  }
  for (std::size_t n = nodes.size(); n-- > 0;) {
    if (nodes[n].own_count == 0) continue;
    const Panel panel = panel_of(n);
    auto inside = x.middleRows(static_cast<Eigen::Index>(nodes[n].first), panel.cols());
    at_boundary.resize(panel.rows() - panel.cols(), x.cols());
    each_boundary(nodes[n], [&](Eigen::Index position, Eigen::Index place, Eigen::Index count) {
      at_boundary.middleRows(place, count) = x.middleRows(position, count);
    });
    inside.noalias() -= panel.bottomRows(panel.rows() - panel.cols()).transpose() * at_boundary;
    panel.topRows(panel.cols()).transpose().triangularView<Eigen::Upper>().solveInPlace(inside);
  }
  Eigen::MatrixXd solution = Eigen::MatrixXd::Zero(right.rows(), right.cols());
  for (Eigen::Index k = 0; k < size; ++k) solution.row(tree_->component()[static_cast<std::size_t>(k)]) = x.row(k);
  return solution;
}

}  // namespace annulus
