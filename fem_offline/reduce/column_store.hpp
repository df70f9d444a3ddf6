#pragma once

#include <Eigen/Core>
#include <vector>

namespace spindle_twin::fem_offline {

/// Columns of a wide matrix in a file without a name in the folder of temporary files (TMPDIR, else /tmp), so that they
/// take no memory: of the FE snapshots a tenth is kept, of a basis few columns are wanted at a time. `Stored` is float
/// or double; the 24 bit of snapshots are enough to choose from and to span with. Every function throws
/// std::runtime_error with the folder and the system's reason where the file fails it; write and the reads may be
/// called by several threads at once.
template <typename Stored>
class ColumnStore {
 public:
  ColumnStore(Eigen::Index rows, Eigen::Index cols);
  ~ColumnStore();
  ColumnStore(const ColumnStore&) = delete;
  ColumnStore& operator=(const ColumnStore&) = delete;

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }

  /// Columns from `first` on.
  void write(Eigen::Index first, const Eigen::MatrixXd& columns);
  /// `count` columns from `first` on; zero where none was written.
  Eigen::MatrixXd block(Eigen::Index first, Eigen::Index count) const;
  /// These columns, in this order.
  Eigen::MatrixXd chosen(const std::vector<int>& indices) const;

 private:
  using StoredMatrix = Eigen::Matrix<Stored, Eigen::Dynamic, Eigen::Dynamic>;
  void read(Eigen::Index first, Eigen::Index count, StoredMatrix& columns) const;

  Eigen::Index rows_, cols_;
  int file_ = -1;
};

}  // namespace spindle_twin::fem_offline
