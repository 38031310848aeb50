#include "sim/collision_scene.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "sim/bullet_units.hpp"

namespace atropos::sim {

namespace {

enum Group : int { kTissueGroup = 64, kInstrumentGroup = 128, kThreadGroup = 256 };

struct MeshBody {
    std::vector<btScalar> vertices;
    std::vector<int> indices;
    std::unique_ptr<btTriangleIndexVertexArray> triangles;
    std::unique_ptr<btBvhTriangleMeshShape> shape;
    std::vector<Eigen::Vector3d> normals_W;  // front side of each triangle
};

struct Object {
    int body = -1, link = -1;
    std::unique_ptr<btCapsuleShapeZ> capsule;
    std::unique_ptr<btCollisionObject> object;
    Eigen::Isometry3d X_LK = Eigen::Isometry3d::Identity();  // capsule in its link
    btTransform before = btTransform::getIdentity();
    bool placed = false;
};

struct Body {
    double friction = 0.0;
    bool is_tissue = false;
    MeshBody mesh;
    std::vector<std::unique_ptr<Object>> objects;
};

Eigen::Isometry3d capsule_pose(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = 0.5 * (a + b);
    const Eigen::Vector3d axis = b - a;
    if (axis.norm() > 1e-12)
        X.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
    return X;
}

/// Links of one instrument do not meet one another, nor do edges of thread (the rod sees to those).
struct Filter : btOverlapFilterCallback {
    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
        if (!((a->m_collisionFilterGroup & b->m_collisionFilterMask) &&
              (b->m_collisionFilterGroup & a->m_collisionFilterMask)))
            return false;
        const auto* first = static_cast<const btCollisionObject*>(a->m_clientObject);
        const auto* second = static_cast<const btCollisionObject*>(b->m_clientObject);
        return first->getUserIndex() != second->getUserIndex() || first->getUserIndex() < 0;
    }
};

struct Action : btActionInterface {
    const std::function<void()>* advance = nullptr;
    void updateAction(btCollisionWorld*, btScalar) override {
        if (advance && *advance) (*advance)();
    }
    void debugDraw(btIDebugDraw*) override {}
};

constexpr int kThreadIndex = -7;  // user index of thread capsules; bodies count from 0

}  // namespace

struct CollisionScene::Impl {
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    Filter filter;
    Action action;
    std::vector<std::unique_ptr<Body>> bodies;
    std::vector<std::unique_ptr<Object>> thread;
    double thread_radius_m = 0.0;

    const Object& object_of(const btCollisionObject& o) const {
        return *static_cast<const Object*>(o.getUserPointer());
    }
    Eigen::Vector3d surface_velocity(const Object& object, const btVector3& p, double dt_s) const {
        if (object.link < 0 || !object.placed) return Eigen::Vector3d::Zero();
        const btVector3 local = object.object->getWorldTransform().inverse() * p;
        return to_metres(p - object.before * local) / dt_s;
    }
};

CollisionScene::CollisionScene(const Eigen::Vector3d& gravity_W_m_s2) : impl_(std::make_unique<Impl>()) {
    impl_->world.setGravity(to_bullet(gravity_W_m_s2));
    impl_->world.getWorldInfo().m_gravity = to_bullet(gravity_W_m_s2);
    impl_->world.getSolverInfo().m_solverMode &= ~SOLVER_RANDMIZE_ORDER;
    impl_->broadphase.getOverlappingPairCache()->setOverlapFilterCallback(&impl_->filter);
    impl_->world.addAction(&impl_->action);
}

CollisionScene::~CollisionScene() {
    impl_->world.removeAction(&impl_->action);
    for (auto& edge : impl_->thread)
        if (edge->object) impl_->world.removeCollisionObject(edge->object.get());
    for (auto& body : impl_->bodies)
        for (auto& object : body->objects)
            if (object->object) impl_->world.removeCollisionObject(object->object.get());
}

btSoftRigidDynamicsWorld& CollisionScene::world() {
    return impl_->world;
}

int CollisionScene::add_mesh(const scenes::TriangleMesh& mesh, const Eigen::Isometry3d& X_WM,
                             double friction) {
    if (mesh.triangles.empty())
        throw std::invalid_argument("tissue mesh has no triangles, expected at least one");
    auto body = std::make_unique<Body>();
    body->friction = friction;
    body->is_tissue = true;
    std::vector<Eigen::Vector3d> vertices_W;
    for (const Eigen::Vector3f& v : mesh.vertices) {
        vertices_W.push_back(X_WM * v.cast<double>());
        const btVector3 p = to_bullet(vertices_W.back());
        for (int k = 0; k < 3; ++k) body->mesh.vertices.push_back(p[k]);
    }
    for (const auto& triangle : mesh.triangles) {
        for (const std::uint32_t index : triangle) {
            if (index >= mesh.vertices.size())
                throw std::invalid_argument("tissue mesh names vertex " + std::to_string(index) +
                                            ", expected fewer than " + std::to_string(mesh.vertices.size()));
            body->mesh.indices.push_back(static_cast<int>(index));
        }
        const Eigen::Vector3d& a = vertices_W[triangle[0]];
        body->mesh.normals_W.push_back(
            (vertices_W[triangle[1]] - a).cross(vertices_W[triangle[2]] - a).normalized());
    }
    body->mesh.triangles = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(mesh.triangles.size()), body->mesh.indices.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(mesh.vertices.size()), body->mesh.vertices.data(),
        static_cast<int>(3 * sizeof(btScalar)));
    body->mesh.shape = std::make_unique<btBvhTriangleMeshShape>(body->mesh.triangles.get(), true);
    body->mesh.shape->setMargin(0.0);
    auto object = std::make_unique<Object>();
    object->body = static_cast<int>(impl_->bodies.size());
    object->object = std::make_unique<btCollisionObject>();
    object->object->setCollisionShape(body->mesh.shape.get());
    object->object->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
    object->object->setUserPointer(object.get());
    object->object->setUserIndex(object->body);
    impl_->world.addCollisionObject(object->object.get(), kTissueGroup,
                                    kInstrumentGroup | kThreadGroup | btBroadphaseProxy::DefaultFilter);
    body->objects.push_back(std::move(object));
    impl_->bodies.push_back(std::move(body));
    return static_cast<int>(impl_->bodies.size()) - 1;
}

int CollisionScene::add_links(const std::vector<std::vector<scenes::Capsule>>& links, double friction) {
    auto body = std::make_unique<Body>();
    body->friction = friction;
    for (size_t link = 0; link < links.size(); ++link)
        for (const scenes::Capsule& capsule : links[link]) {
            if (!(capsule.radius_m > 0.0))
                throw std::invalid_argument("link capsule has no radius, expected more than 0 m");
            auto object = std::make_unique<Object>();
            object->body = static_cast<int>(impl_->bodies.size());
            object->link = static_cast<int>(link);
            object->X_LK = capsule_pose(capsule.a, capsule.b);
            object->capsule = std::make_unique<btCapsuleShapeZ>(
                capsule.radius_m * kUnitsPerMetre, (capsule.b - capsule.a).norm() * kUnitsPerMetre);
            body->objects.push_back(std::move(object));
        }
    impl_->bodies.push_back(std::move(body));
    return static_cast<int>(impl_->bodies.size()) - 1;
}

void CollisionScene::set_link_poses(int body, std::span<const Eigen::Isometry3d> X_WL) {
    for (auto& object : impl_->bodies.at(static_cast<size_t>(body))->objects) {
        if (static_cast<size_t>(object->link) >= X_WL.size())
            throw std::invalid_argument("got " + std::to_string(X_WL.size()) +
                                        " link poses, expected one for each link");
        const btTransform pose = to_bullet(X_WL[static_cast<size_t>(object->link)] * object->X_LK);
        if (object->placed) {
            object->object->setWorldTransform(pose);
            continue;
        }
        object->object = std::make_unique<btCollisionObject>();
        object->object->setCollisionShape(object->capsule.get());
        object->object->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        object->object->setActivationState(DISABLE_DEACTIVATION);
        object->object->setUserPointer(object.get());
        object->object->setUserIndex(object->body);
        object->object->setWorldTransform(pose);
        object->before = pose;
        object->placed = true;
        impl_->world.addCollisionObject(
            object->object.get(), kInstrumentGroup,
            kInstrumentGroup | kTissueGroup | kThreadGroup | btBroadphaseProxy::DefaultFilter);
    }
}

void CollisionScene::set_thread(const ThreadState& state, double radius_m) {
    const auto edges = static_cast<size_t>(std::max(state.edge_count(), 0));
    impl_->thread_radius_m = radius_m;
    bool same = impl_->thread.size() == edges;
    const double radius = (radius_m + kAnnounced_m) * kUnitsPerMetre;
    for (size_t i = 0; i < edges && same; ++i)
        same = !state.joined[i] == !impl_->thread[i]->capsule ||
               (impl_->thread[i]->capsule &&
                std::abs(2.0 * impl_->thread[i]->capsule->getHalfHeight() / kUnitsPerMetre -
                         state.rest_length_m(static_cast<int>(i))) < 1e-12);
    if (!same) {
        for (auto& edge : impl_->thread)
            if (edge->object) impl_->world.removeCollisionObject(edge->object.get());
        impl_->thread.clear();
        for (size_t i = 0; i < edges; ++i) {
            auto edge = std::make_unique<Object>();
            edge->link = static_cast<int>(i);
            impl_->thread.push_back(std::move(edge));
        }
    }
    for (size_t i = 0; i < edges; ++i) {
        Object& edge = *impl_->thread[i];
        if (!state.joined[i]) continue;
        const btTransform pose = to_bullet(capsule_pose(state.p_W[i], state.p_W[i + 1]));
        if (edge.object) {
            edge.object->setWorldTransform(pose);
            continue;
        }
        edge.capsule = std::make_unique<btCapsuleShapeZ>(
            radius, state.rest_length_m(static_cast<int>(i)) * kUnitsPerMetre);
        edge.object = std::make_unique<btCollisionObject>();
        edge.object->setCollisionShape(edge.capsule.get());
        edge.object->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT |
                                       btCollisionObject::CF_NO_CONTACT_RESPONSE);
        edge.object->setActivationState(DISABLE_DEACTIVATION);
        edge.object->setUserPointer(&edge);
        edge.object->setUserIndex(kThreadIndex);
        edge.object->setWorldTransform(pose);
        impl_->world.addCollisionObject(edge.object.get(), kThreadGroup, kInstrumentGroup | kTissueGroup);
    }
}

void CollisionScene::begin_step() {
    // Points cached from earlier ticks would carry old normals; only this tick's closest points count.
    for (int i = 0; i < impl_->dispatcher.getNumManifolds(); ++i)
        impl_->dispatcher.getManifoldByIndexInternal(i)->clearManifold();
}

void CollisionScene::end_step() {
    for (auto& body : impl_->bodies)
        for (auto& object : body->objects)
            if (object->placed) object->before = object->object->getWorldTransform();
}

void CollisionScene::step(double dt_s, const std::function<void()>& advance) {
    begin_step();
    impl_->action.advance = &advance;
    impl_->world.stepSimulation(dt_s, 0);
    impl_->action.advance = nullptr;
    end_step();
}

std::vector<SurfaceContact> CollisionScene::thread_contacts(double dt_s) const {
    std::vector<SurfaceContact> faces, rims;  // on the inside of a triangle, and on its edges and corners
    for (int i = 0; i < impl_->dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *impl_->dispatcher.getManifoldByIndexInternal(i);
        const bool thread_first = manifold.getBody0()->getUserIndex() == kThreadIndex;
        if (!thread_first && manifold.getBody1()->getUserIndex() != kThreadIndex) continue;
        const Object& edge = impl_->object_of(thread_first ? *manifold.getBody0() : *manifold.getBody1());
        const Object& other = impl_->object_of(thread_first ? *manifold.getBody1() : *manifold.getBody0());
        const Body& body = *impl_->bodies[static_cast<size_t>(other.body)];
        for (int k = 0; k < manifold.getNumContacts(); ++k) {
            const btManifoldPoint& point = manifold.getContactPoint(k);
            SurfaceContact contact;
            contact.edge = edge.link;
            contact.normal_W = to_direction(point.m_normalWorldOnB) * (thread_first ? 1.0 : -1.0);
            const btVector3& surface =
                thread_first ? point.getPositionWorldOnB() : point.getPositionWorldOnA();
            contact.p_surface_W = to_metres(surface);
            if (!contact.normal_W.allFinite() || std::abs(contact.normal_W.norm() - 1.0) > 1e-3) continue;
            bool on_face = true;
            if (body.is_tissue) {
                const int triangle = thread_first ? point.m_index1 : point.m_index0;
                const Eigen::Vector3d& front =
                    body.mesh.normals_W[static_cast<size_t>(std::max(triangle, 0))];
                const double facing = contact.normal_W.dot(front);
                // A thread pressed through the surface must come back out on the front.
                if (facing < 0.0 || facing > 0.999) contact.normal_W = front;
                on_face = facing < 0.0 || facing > 0.999;
            }
            const btTransform& pose = edge.object->getWorldTransform();
            const double half = edge.capsule->getHalfHeight();
            const double along = (pose.inverse() * surface).z();
            contact.t = half > 0.0 ? std::clamp(0.5 + 0.5 * along / half, 0.0, 1.0) : 0.5;
            contact.v_surface_W = impl_->surface_velocity(other, surface, dt_s);
            contact.friction = body.friction;
            contact.body = other.body;
            (on_face ? faces : rims).push_back(contact);
        }
    }
    // The rim of a triangle next to the one that is touched is no edge of the surface: its slanting normal
    // would push the thread sideways on a plane.
    std::vector<SurfaceContact> contacts = faces;
    for (const SurfaceContact& rim : rims) {
        const bool inner = std::any_of(faces.begin(), faces.end(), [&](const SurfaceContact& face) {
            return face.body == rim.body && std::abs(face.edge - rim.edge) <= 1 &&
                   std::abs(face.normal_W.dot(rim.p_surface_W - face.p_surface_W)) < 1e-5;
        });
        if (!inner) contacts.push_back(rim);
    }
    std::sort(contacts.begin(), contacts.end(), [](const SurfaceContact& a, const SurfaceContact& b) {
        return std::tuple(a.edge, a.body, a.t, a.p_surface_W.x(), a.p_surface_W.y(), a.p_surface_W.z()) <
               std::tuple(b.edge, b.body, b.t, b.p_surface_W.x(), b.p_surface_W.y(), b.p_surface_W.z());
    });
    return contacts;
}

std::vector<BodyOverlap> CollisionScene::overlaps() const {
    std::vector<BodyOverlap> result;
    for (int i = 0; i < impl_->dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *impl_->dispatcher.getManifoldByIndexInternal(i);
        const auto* o0 = manifold.getBody0();
        const auto* o1 = manifold.getBody1();
        if (o0->getUserIndex() < 0 || o1->getUserIndex() < 0 || !o0->getUserPointer() ||
            !o1->getUserPointer())
            continue;
        for (int k = 0; k < manifold.getNumContacts(); ++k) {
            const btManifoldPoint& point = manifold.getContactPoint(k);
            if (point.getDistance() >= 0.0) continue;
            const Object *a = &impl_->object_of(*o0), *b = &impl_->object_of(*o1);
            if (a->body > b->body) std::swap(a, b);
            result.push_back({a->body, b->body, a->link, b->link, to_metres(point.getPositionWorldOnB()),
                              -point.getDistance() / kUnitsPerMetre});
        }
    }
    std::sort(result.begin(), result.end(), [](const BodyOverlap& a, const BodyOverlap& b) {
        return std::tuple(a.first, a.second, a.first_link, a.second_link, b.depth_m) <
               std::tuple(b.first, b.second, b.first_link, b.second_link, a.depth_m);
    });
    return result;
}

}  // namespace atropos::sim
