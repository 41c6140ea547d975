#include "fitting/frontal_inverse.h"

#include <algorithm>

namespace annulus {
namespace {

std::vector<std::int32_t> Parents(const EliminationTree& tree) {
  std::vector<std::int32_t> parents(tree.nodes().size(), -1);
  for (std::size_t n = 0; n < parents.size(); ++n) {
    for (const std::int32_t child : {tree.nodes()[n].left, tree.nodes()[n].right}) {
      if (child >= 0) parents[static_cast<std::size_t>(child)] = static_cast<std::int32_t>(n);
    }
  }
  return parents;
}

/// Entry of a gradient by the order of elimination.
struct PlacedWeight {
  std::uint32_t position = 0;
  double weight = 0.0;
  std::size_t row = 0;  ///< In the front at hand.
};

}  // namespace

FrontalInverse::FrontalInverse(const FrontalCholesky& factor) : tree_(factor.shared_tree()) {
  const std::vector<EliminationNode>& nodes = tree_->nodes();
  const std::vector<std::int32_t> parents = Parents(*tree_);
  std::size_t total = 0;
  for (const EliminationNode& node : nodes) {
    panel_first_.push_back(total);
    total += std::size_t{node.own_count} * (node.own_count + node.boundary_count);
  }
  panels_.resize(total);
  std::vector<Eigen::MatrixXd> fronts(nodes.size());  // only of nodes whose children are still to come
  for (std::size_t n = nodes.size(); n-- > 0;) {
    const EliminationNode& node = nodes[n];
    const auto own = static_cast<Eigen::Index>(node.own_count);
    const auto boundary = static_cast<Eigen::Index>(node.boundary_count);
    Eigen::MatrixXd z(own + boundary, own + boundary);
    if (parents[n] >= 0) {
      const auto parent = static_cast<std::size_t>(parents[n]);
      const std::span<const std::uint32_t> place = tree_->PlaceInParent(node);
      for (Eigen::Index b = 0; b < boundary; ++b) {
        const double* from = fronts[parent].col(place[static_cast<std::size_t>(b)]).data();
        for (Eigen::Index a = 0; a < boundary; ++a) z(own + a, own + b) = from[place[static_cast<std::size_t>(a)]];
      }
      if (nodes[parent].left == static_cast<std::int32_t>(n)) fronts[parent].resize(0, 0);  // the last to need it
    }
    if (own > 0) {
      const FrontalCholesky::Columns columns = factor.ColumnsOf(n);
      const auto lower = columns.topRows(own).triangularView<Eigen::Lower>();
      const Eigen::MatrixXd root = lower.solve(Eigen::MatrixXd::Identity(own, own));
      z.topLeftCorner(own, own).noalias() = root.transpose() * root;
      if (boundary > 0) {
        const Eigen::MatrixXd x = lower.transpose().solve(columns.bottomRows(boundary).transpose()).transpose();
        z.bottomLeftCorner(boundary, own).noalias() = -z.bottomRightCorner(boundary, boundary) * x;
        z.topLeftCorner(own, own).noalias() -= x.transpose() * z.bottomLeftCorner(boundary, own);
      }
    }
    Eigen::Map<Eigen::MatrixXd>(panels_.data() + panel_first_[n], own + boundary, own) = z.leftCols(own);
    if (node.left < 0) continue;
    z.topRightCorner(own, boundary) = z.bottomLeftCorner(boundary, own).transpose();
    fronts[n] = std::move(z);
  }
}

std::optional<double> FrontalInverse::Variance(std::span<const CoefficientWeight> gradient) const {
  std::vector<PlacedWeight> entries;
  for (const CoefficientWeight& entry : gradient) {
    if (entry.weight != 0.0) entries.push_back({tree_->position()[entry.index], entry.weight, 0});
  }
  std::sort(entries.begin(), entries.end(),
            [](const PlacedWeight& a, const PlacedWeight& b) { return a.position < b.position; });
  double variance = 0.0;
  std::optional<std::uint32_t> last;
  for (std::size_t a = 0; a < entries.size(); ++a) {
    const std::uint32_t n = tree_->owner()[entries[a].position];
    const EliminationNode& node = tree_->nodes()[n];
    if (last != n) {
      for (std::size_t b = a; b < entries.size(); ++b) {
        const std::optional<std::size_t> row = tree_->PlaceInFront(node, entries[b].position);
        if (!row) return std::nullopt;
        entries[b].row = *row;
      }
      last = n;
    }
    const double* column = panels_.data() + panel_first_[n] +
                           std::size_t{entries[a].position - node.own_first} * (node.own_count + node.boundary_count);
    double sum = 0.5 * entries[a].weight * column[entries[a].row];
    for (std::size_t b = a + 1; b < entries.size(); ++b) sum += entries[b].weight * column[entries[b].row];
    variance += 2.0 * entries[a].weight * sum;
  }
  return std::max(variance, 0.0);
}

}  // namespace annulus
