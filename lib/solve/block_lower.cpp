// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/solve/block_lower.hpp>

namespace mapjoin {

void BlockLower::lay_out() {
  for (const Column k : columns()) {
    Eigen::Index height = 0;
    for (const Column row : rows[k]) height += dof(row);
    heights.push_back(height);
    first_value.push_back(first_value.back() + height * dof(k));
  }
  values.assign(static_cast<std::size_t>(first_value.back()), 0.0);
}

Eigen::VectorXd BlockLower::diagonal() const {
  Eigen::VectorXd diagonal(size());
  for (const Column k : columns()) diagonal.segment(offsets[k], dof(k)) = panel(k).diagonal();
  return diagonal;
}

void BlockLower::set_diagonal(const Eigen::VectorXd& diagonal) {
  for (const Column k : columns()) panel(k).diagonal() = diagonal.segment(offsets[k], dof(k));
}

Eigen::VectorXd BlockLower::operator*(const Eigen::VectorXd& v) const {
  Eigen::VectorXd product = Eigen::VectorXd::Zero(v.size());
  for (const Column k : columns()) {
    const auto v_k = v.segment(offsets[k], dof(k));
    product.segment(offsets[k], dof(k)) += panel(k).topRows(dof(k)).selfadjointView<Eigen::Lower>() * v_k;
    Eigen::Index row = dof(k);
    for (const Column below : rows[k].subspan(1)) {
      const auto block = panel(k).middleRows(row, dof(below));
      product.segment(offsets[below], dof(below)) += block.lazyProduct(v_k);
      product.segment(offsets[k], dof(k)) += block.transpose().lazyProduct(v.segment(offsets[below], dof(below)));
      row += dof(below);
    }
  }
  return product;
}

BlockLower BlockLower::principal_submatrix(const Table<Column, bool>& is_kept) const {
  Table<Column, Column> kept(is_kept.size());  // the column among those that are kept
  BlockLower part;
  for (const Column k : columns()) {
    kept[k] = Column(part.offsets.size() - 1);
    if (is_kept[k]) part.offsets.push_back(part.offsets.back() + dof(k));
  }
  for (const Column k : columns()) {
    std::vector<Column> kept_rows;
    for (const Column row : rows[k]) {
      if (is_kept[row]) kept_rows.push_back(kept[row]);
    }
    if (is_kept[k]) part.rows.push_back(kept_rows);
  }
  part.lay_out();
  for (const Column k : columns()) {
    if (!is_kept[k]) continue;
    Eigen::Index from = 0;
    Eigen::Index to = 0;
    for (const Column row : rows[k]) {
      if (is_kept[row])
        part.panel(kept[k]).middleRows(std::exchange(to, to + dof(row)), dof(row)) = panel(k).middleRows(from, dof(row));
      from += dof(row);
    }
  }
  return part;
}

}  // namespace mapjoin
