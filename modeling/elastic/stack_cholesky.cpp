#include "modeling/elastic/stack_cholesky.h"

#include <utility>
#include <vector>

namespace annulus {
namespace {

using Eigen::Index;
using Panel = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

Panel PanelOf(const FrontPanels& panels, std::size_t n, const FrontSize& size) {
  return {panels[n], static_cast<Index>(size.own + size.boundary), static_cast<Index>(size.own),
          Eigen::OuterStride<>(static_cast<Index>(size.panel_stride()))};
}

}  // namespace

StackCholesky::StackCholesky(std::shared_ptr<const StackTree> tree) : tree_(std::move(tree)) {
  std::vector<FrontSize> sizes;
  for (const StackNode& node : tree_->nodes()) sizes.push_back(node.size);
  panels_ = FrontPanels(sizes);
}

bool StackCholesky::Factor(const PileMatrix& pile_matrix) {
  const std::size_t stride = 12 * tree_->shape().layers;
  panels_.SetZero();
  waiting_.Clear();
  std::vector<const StackNode*> children;  // whose complements wait
  for (std::size_t n = 0; n < tree_->nodes().size(); ++n) {
    const StackNode& node = tree_->nodes()[n];
    const Front front{node.size, panels_[n], waiting_.Push(node.size)};
    for (const std::uint32_t pile : node.piles) {
      AddToFront(pile_matrix(pile), stride, tree_->PlacesOf(pile), front);
    }
    for (std::size_t k = 1; k <= node.children; ++k) {
      const StackNode& child = *children[children.size() - k];
      AddChildToFront(waiting_.FromTop(k + 1), child.size, child.place_in_parent, front);
    }
    if (!front.Eliminate()) return false;
    waiting_.DropBelowTop(node.children);
    children.resize(children.size() - node.children);
    children.push_back(&node);
  }
  return true;
}

template <class Right>
Right StackCholesky::SolveFor(const Right& right) const {
  const std::vector<StackNode>& nodes = tree_->nodes();
  const std::vector<std::uint32_t>& component = tree_->component();
  Right x(static_cast<Index>(tree_->size()), right.cols());
  for (std::size_t k = 0; k < component.size(); ++k) x.row(static_cast<Index>(k)) = right.row(component[k]);
  Right outside;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Panel panel = PanelOf(panels_, n, nodes[n].size);
    auto inside = x.middleRows(static_cast<Index>(nodes[n].first), panel.cols());
    panel.topRows(panel.cols()).template triangularView<Eigen::Lower>().solveInPlace(inside);
    outside.noalias() = panel.bottomRows(panel.rows() - panel.cols()) * inside;
    for (Index k = 0; k < outside.rows(); ++k) {
      x.row(nodes[n].boundary[static_cast<std::size_t>(k)]) -= outside.row(k);
    }
  }
  for (std::size_t n = nodes.size(); n-- > 0;) {
    const Panel panel = PanelOf(panels_, n, nodes[n].size);
    auto inside = x.middleRows(static_cast<Index>(nodes[n].first), panel.cols());
    outside.resize(panel.rows() - panel.cols(), x.cols());
    for (Index k = 0; k < outside.rows(); ++k) {
      outside.row(k) = x.row(nodes[n].boundary[static_cast<std::size_t>(k)]);
    }
    inside.noalias() -= panel.bottomRows(outside.rows()).transpose() * outside;
    panel.topRows(panel.cols()).transpose().template triangularView<Eigen::Upper>().solveInPlace(inside);
  }
  Right solution = Right::Zero(right.rows(), right.cols());
  for (std::size_t k = 0; k < component.size(); ++k) solution.row(component[k]) = x.row(static_cast<Index>(k));
  return solution;
}

Eigen::VectorXd StackCholesky::Solve(const Eigen::VectorXd& right) const { return SolveFor(right); }
Eigen::MatrixXd StackCholesky::Solve(const Eigen::MatrixXd& right) const { return SolveFor(right); }

}  // namespace annulus
