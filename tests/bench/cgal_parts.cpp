// CGAL's Surface_mesh_segmentation with its defaults: `cgal_parts MESH.obj OUT.seg` writes a label a face and prints
// the processor seconds of shape diameter and cut together (reading is left out).
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/mesh_segmentation.h>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

static double seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int count, char** arguments) {
    if (count != 3) return std::fputs("usage: cgal_parts MESH.obj OUT.seg\n", stderr), 2;
    std::ifstream file(arguments[1]);
    Mesh mesh;
    std::map<Point, Mesh::Vertex_index> places;  // equal positions are one vertex, as in our own bench
    std::vector<Mesh::Vertex_index> vertices;
    std::vector<Mesh::Face_index> faces;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") {
            double x, y, z;
            words >> x >> y >> z;
            Point p(x, y, z);
            auto place = places.find(p);
            if (place == places.end()) place = places.emplace(p, mesh.add_vertex(p)).first;
            vertices.push_back(place->second);
        } else if (kind == "f") {
            std::vector<Mesh::Vertex_index> corners;
            for (std::string word; words >> word;) corners.push_back(vertices[std::stoul(word) - 1]);
            faces.push_back(mesh.add_face(corners));  // the null face where it would not be manifold
        }
    }
    double start = seconds();
    auto diameter = mesh.add_property_map<Mesh::Face_index, double>("f:diameter").first;
    auto part = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:part").first;
    CGAL::sdf_values(mesh, diameter);
    CGAL::segmentation_from_sdf_values(mesh, diameter, part);
    double spent = seconds() - start;
    std::ofstream out(arguments[2]);
    for (auto face : faces) out << (face == Mesh::null_face() ? 0 : part[face]) << '\n';
    std::printf("%.3f\n", spent);
}
