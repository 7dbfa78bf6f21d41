// What may be written where: targets and how they are refused, inputs that no output may replace by
// whatever name, full disks and limits, several writers of one name, and outputs that are
// abandoned.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "tests/unit/volumes/io/io_fixture.hpp"
#include "volumes/io/file.hpp"
#include "volumes/io/unfinished.hpp"

namespace cvr::volumes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Outputs : public IoTest {
 protected:
  template <class Error, class Act>
  static void expect_throw(Act act, const std::string& text) {
    try {
      act();
      ADD_FAILURE() << "nothing was thrown, expected: " << text;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(text));
    }
  }
  void expect_refused(const std::string& name, const std::string& text) const {
    expect_throw<OutputError>([&] { check_output(name); }, text);
    expect_throw<OutputError>([&] { OutputFile file(name); }, text);
  }
  static Volume small() { return patterned({5, 7, 3}, VoxelType::kU32, VolumeKind::kLabels); }
};

const std::vector<std::string> kNames{"a.h5",     "b.nrrd", "c.nhdr",       "d.nii",
                                      "e.nii.gz", "f.raw",  "g.precomputed"};

TEST_F(Outputs, OnlyPlainFilesAreReplaced) {
  fs::create_directory(path("folder"));
  expect_refused(path("folder"), "a folder has this name");
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  expect_refused(path("pipe"), "a device, pipe or socket has this name");
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path("socket").copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(socket);
  expect_refused(path("socket"), "a device, pipe or socket has this name");
  fs::create_symlink("nothing", path("dangling"));
  expect_refused(path("dangling"), "a symbolic link to a file that is missing");
  fs::create_symlink("loop", path("loop"));
  expect_refused(path("loop"), "ymbolic link");
  expect_refused(path("none/file"), "there is no folder '" + path("none") + "'");
  write_bytes("plain", "text");
  expect_refused(path("plain/file"), "Not a directory");
  expect_refused("/dev/null", "it names a device or an open file");
  expect_refused("/dev/stdout", "it names a device or an open file");
  expect_refused("/proc/self/fd/1", "it names a device or an open file");
  expect_refused("", "a name is missing");
  expect_files({"dangling", "folder", "loop", "pipe", "plain", "socket"});
}

TEST_F(Outputs, ALinkStaysALinkAndAReplacedFileKeepsItsPermissions) {
  fs::create_directory(path("elsewhere"));
  write_bytes("elsewhere/real", "old");
  fs::permissions(path("elsewhere/real"), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("elsewhere/real", path("link"));
  write_whole_file(path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(read_bytes(path("elsewhere/real")), "new");
  EXPECT_EQ(fs::status(path("elsewhere/real")).permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
  // A header lies beside the file itself and not beside a link to it.
  write_volume(path("elsewhere/a.raw"), MemorySource(small()));
  fs::create_symlink("elsewhere/a.raw", path("b.raw"));
  expect_throw<OutputError>([&] { write_volume(path("b.raw"), MemorySource(small())); },
                            "symbolic link");
  expect_files({"b.raw", "elsewhere", "link"});
}

TEST_F(Outputs, InputsAreNotReplacedByWhateverName) {
  write_bytes("data/in", "precious");
  fs::create_symlink("data/in", path("symbolic"));
  fs::create_hard_link(path("data/in"), path("hard"));
  fs::create_directory_symlink("data", path("folder"));
  const std::string input = path("data/in");
  for (const std::string& name :
       {path("data/in"), path("data/../data/./in"), path("symbolic"), path("hard"),
        path("folder/in"), fs::relative(path("data/in")).string()}) {
    expect_throw<InputError>(
        [&] {
          refuse_to_replace({path("other"), name}, {path("nothing"), input});
        },
        name + ": expected another file than the input, found '" + input + "'");
  }
  expect_throw<InputError>([&] { refuse_to_replace({path("data/new.h5")}, {path("data")}); },
                           "a place outside the input");
  expect_throw<InputError>([&] { refuse_to_replace({path("folder/new/er.h5")}, {path("data")}); },
                           "a place outside the input");
  expect_throw<InputError>([&] { refuse_to_replace({path("data/")}, {input}); },
                           "a folder without the input");
  refuse_to_replace({path("new"), path("data2/new"), path("datax")}, {path("data"), path("hard")});
}

/// Writers ask their sources: one stands for all readers here.
TEST_F(Outputs, WritersRefuseToReplaceWhatTheirSourceReads) {
  class Reading final : public VolumeSource {
   public:
    Reading(const Volume& volume, std::vector<std::string> files)
        : memory_(volume), files_(std::move(files)) {}
    const VolumeInfo& info() const override { return memory_.info(); }
    void read(const Box& box, std::byte* out) const override { memory_.read(box, out); }
    std::vector<std::string> files() const override { return files_; }

   private:
    MemorySource memory_;
    std::vector<std::string> files_;
  };
  const Volume volume = small();
  for (const std::string& name : kNames) {
    write_volume(path(name), MemorySource(volume));
    for (const std::string& output : volume_outputs(path(name))) {
      const Reading source(volume, {output});
      expect_throw<InputError>([&] { write_volume(path(name), source); }, "which is read");
      expect_throw<InputError>([&] { check_volume_output(path(name), {output}); }, "which is read");
    }
    expect_boxes(*open_volume(path(name)), volume);
  }
  EXPECT_EQ(volume_outputs("x/f.raw"), (std::vector<std::string>{"x/f.raw", "x/f.raw.yaml"}));
  EXPECT_EQ(volume_outputs("c.nhdr"), (std::vector<std::string>{"c.nhdr", "c.nhdr.bin"}));
  EXPECT_EQ(volume_outputs("F.RAW"), (std::vector<std::string>{"F.RAW", "F.RAW.yaml"}));
  EXPECT_EQ(volume_outputs("C.Nhdr"), (std::vector<std::string>{"C.Nhdr", "C.Nhdr.bin"}));
  EXPECT_EQ(volume_outputs("a.h5:/x"), (std::vector<std::string>{"a.h5"}));
  // What a reader says it reads is refused: the folder of a precomputed volume.
  const auto folder = open_volume(path("g.precomputed"));
  expect_throw<InputError>([&] { write_volume(path("g.precomputed"), *folder); }, "which is read");
  expect_throw<InputError>([&] { write_volume(path("g.precomputed/a.h5"), *folder); },
                           "which is read");
  expect_throw<InputError>([&] { write_volume(path("g.precomputed/8_4.5_40/"), *folder); },
                           "which is read");
  expect_boxes(*open_volume(path("g.precomputed")), volume);
}

/// Runs `act` in a process of its own, which may spoil its limits; its exit code says what was
/// thrown.
template <class Act>
int in_child(Act act) {
  const pid_t child = ::fork();
  if (child == 0) {
    int code = 0;
    try {
      act();
    } catch (const OutputError&) {
      code = 3;
    } catch (const InputError&) {
      code = 2;
    }
    ::_exit(code);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// A limit of the size of files stands for a full disk: both fail in the middle of a write. HDF5
/// has tests of its own.
TEST_F(Outputs, NothingIsLeftWhereThereIsNoRoom) {
  const Volume big = patterned({70, 60, 50}, VoxelType::kU32, VolumeKind::kLabels);
  const Volume scalars = patterned({70, 60, 50}, VoxelType::kF32, VolumeKind::kScalars);
  for (const std::string& name : kNames) {
    if (name == "a.h5") continue;
    const Volume& volume = name == "g.precomputed" ? scalars : big;
    EXPECT_EQ(in_child([&] {
                ::signal(SIGXFSZ, SIG_IGN);
                const rlimit limit{4096, 4096};
                ::setrlimit(RLIMIT_FSIZE, &limit);
                write_volume(path(name), MemorySource(volume));
              }),
              3)
        << name;
  }
  expect_files({});
}

TEST_F(Outputs, AReadOnlyFolderOrFileIsNotWritten) {
  write_bytes("locked/file", "old");
  write_bytes("file", "old");
  fs::permissions(path("file"), fs::perms::owner_read);
  fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  fs::permissions(folder_, fs::perms::all);
  for (const std::string& name :
       {path("locked/new"), path("locked/file"), path("file"), path("locked/new.precomputed")}) {
    EXPECT_EQ(in_child([&] {
                if (::geteuid() == 0 && ::setuid(65534) != 0) ::_exit(99);
                name.ends_with(".precomputed") ? write_volume(name, MemorySource(small()))
                                               : write_whole_file(name, "new");
              }),
              3)
        << name;
    EXPECT_EQ(in_child([&] {
                if (::geteuid() == 0 && ::setuid(65534) != 0) ::_exit(99);
                name.ends_with(".precomputed") ? check_volume_output(name, {}) : check_output(name);
              }),
              3)
        << name;
  }
  fs::permissions(path("locked"), fs::perms::owner_all);
  EXPECT_EQ(read_bytes(path("file")), "old");
  EXPECT_EQ(read_bytes(path("locked/file")), "old");
}

/// Whoever is last wins, whole: voxels of one writer are never described by the header of another.
TEST_F(Outputs, SeveralWritersOfOneNameTearNothing) {
  const std::array volumes{patterned({12, 10, 8}, VoxelType::kU32, VolumeKind::kLabels),
                           patterned({8, 10, 12}, VoxelType::kU32, VolumeKind::kLabels)};
  for (const std::string name : {"b.nrrd", "c.nhdr", "e.nii.gz", "f.raw", "g.precomputed"}) {
    std::vector<std::jthread> writers;
    for (const Volume& volume : volumes) {
      writers.emplace_back([&, name] {
        for (int i = 0; i < 20; ++i) write_volume(path(name), MemorySource(volume));
      });
    }
    writers.clear();
    const auto source = open_volume(path(name));
    const Volume& last = source->info().extent == volumes[0].extent() ? volumes[0] : volumes[1];
    ASSERT_EQ(source->info().extent, last.extent()) << name;
    expect_boxes(*source, last);
  }
  expect_files(
      {"b.nrrd", "c.nhdr", "c.nhdr.bin", "e.nii.gz", "f.raw", "f.raw.yaml", "g.precomputed"});
}

/// abandon_outputs ends all writing of a process for good, so this runs in one of its own.
TEST_F(Outputs, AbandonedOutputsAreRemovedAndStayAway) {
  write_bytes("old", "old");
  EXPECT_EQ(in_child([&] {
              OutputFile fresh(path("new")), replacing(path("old"));
              fresh.write("half");
              replacing.write("half");
              class Stuck final : public VolumeSource {
               public:
                const VolumeInfo& info() const override { return info_; }
                void read(const Box& box, std::byte* out) const override {
                  if (box.origin.z > 0) {
                    abandon_outputs();
                    ::_exit(7);
                  }
                  std::memset(out, 1, box.size.voxels());
                }

               private:
                VolumeInfo info_{.extent = {64, 64, 200}, .type = VoxelType::kU8, .voxel_unit = {}};
              };
              write_volume(path("g.precomputed"), Stuck());
            }),
            7);
  EXPECT_EQ(read_bytes(path("old")), "old");
  expect_files({"old"});
}

TEST_F(Outputs, FolderOutputsTellAtOnceWhatIsInTheWay) {
  write_bytes("file.precomputed", "mine");
  expect_throw<OutputError>([&] { check_volume_output(path("file.precomputed"), {}); },
                            "a file, device, pipe or socket has this name");
  expect_throw<OutputError>([&] { check_volume_output(path("none/a.precomputed"), {}); },
                            "there is no folder");
  const fs::path before = fs::current_path();
  fs::create_directories(path("work/in"));
  fs::current_path(path("work/in"));
  for (const char* name : {"./", "../", "../in/"}) {
    expect_throw<OutputError>([&] { check_volume_output(name, {}); },
                              "it is the current folder or one above it");
  }
  fs::current_path(before);
  expect_throw<InputError>([&] { check_volume_output(path("work"), {}); }, "work/'");
}

}  // namespace
}  // namespace cvr::volumes
