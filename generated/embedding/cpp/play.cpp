/* Physical deception in C++17, played by the generated policies. Build and run, in this folder:
 *
 *   c++ -std=c++17 -O2 -ffp-contract=off play.cpp -o play && ./play
 *
 *   play [EPISODES [SEED]]    prints how many episodes each team won
 *   play --starts             reads starts from standard input, one a line: the goal's number, then ten coordinates;
 *                             prints both successes and every step's actions
 *
 * The header's constants move the agents: nothing of the game is written here but its measure of success.
 */
#include "../../physical_deception/physical_deception.h"
#include <array>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <random>
#include <sstream>
#include <string>

namespace {

constexpr int kAgents = 3;
constexpr int kSteps = 25;
constexpr double kSquaredRadius = 0.1; /* of success: the radius is its root, 0.316 */
constexpr std::array<std::array<double, 2>, 5> kEffect = {{{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
constexpr std::array<double, kAgents> kForce = {
    PHYSICAL_DECEPTION_ADVERSARY_0_FORCE, PHYSICAL_DECEPTION_AGENT_0_FORCE, PHYSICAL_DECEPTION_AGENT_1_FORCE};

struct Episode {
    bool adversary = false;
    bool defenders = false;
    std::string actions;
};

class World {
public:
    World(int goal, const std::array<double, 10> &position)
    {
        for (std::size_t i = 0; i < position.size(); i++) {
            w_[PHYSICAL_DECEPTION_W_ADVERSARY_0_X + i] = position[i];
        }
        w_[PHYSICAL_DECEPTION_W_GOAL_X] = w_[PHYSICAL_DECEPTION_W_LANDMARK_0_X + 2 * goal];
        w_[PHYSICAL_DECEPTION_W_GOAL_Y] = w_[PHYSICAL_DECEPTION_W_LANDMARK_0_Y + 2 * goal];
    }

    Episode play()
    {
        Episode episode;
        for (int t = 0; t < kSteps; t++) {
            std::array<int, kAgents> actions{};
            physical_deception_act_team(w_.data(), actions.data());
            episode.actions += ' ';
            for (int action : actions) {
                episode.actions += static_cast<char>('0' + action);
            }
            step(actions);
            episode.adversary |= near(0, PHYSICAL_DECEPTION_W_GOAL_X);
            episode.defenders |= covered(1, 2) || covered(2, 1);
        }
        return episode;
    }

private:
    void step(const std::array<int, kAgents> &actions)
    {
        for (int agent = 0; agent < kAgents; agent++) {
            for (int axis = 0; axis < 2; axis++) {
                double &p = w_[PHYSICAL_DECEPTION_W_ADVERSARY_0_X + 2 * agent + axis];
                double &v = w_[PHYSICAL_DECEPTION_W_ADVERSARY_0_VX + 2 * agent + axis];
                p = p + v * PHYSICAL_DECEPTION_DT;
                v = v * (1.0 - PHYSICAL_DECEPTION_DAMPING) + kEffect[actions[agent]][axis] * kForce[agent] * PHYSICAL_DECEPTION_DT;
            }
        }
    }

    bool near(int agent, int target) const
    {
        const double dx = w_[PHYSICAL_DECEPTION_W_ADVERSARY_0_X + 2 * agent] - w_[target];
        const double dy = w_[PHYSICAL_DECEPTION_W_ADVERSARY_0_Y + 2 * agent] - w_[target + 1];
        return dx * dx + dy * dy < kSquaredRadius;
    }

    bool covered(int first, int second) const
    {
        return near(first, PHYSICAL_DECEPTION_W_LANDMARK_0_X) && near(second, PHYSICAL_DECEPTION_W_LANDMARK_1_X);
    }

    std::array<double, PHYSICAL_DECEPTION_N_COORDINATES> w_{};
};

int play_lines()
{
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        std::string word;
        std::array<double, 10> position{};
        words >> word;
        const int goal = word == "1" ? 1 : 0;
        for (double &value : position) {
            words >> word;
            value = std::stod(word);
        }
        const Episode episode = World(goal, position).play();
        std::printf("%d %d%s\n", episode.adversary, episode.defenders, episode.actions.c_str());
    }
    return 0;
}

double uniform(std::mt19937_64 &random)
{
    return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; /* the same everywhere, unlike std's distributions */
}

} // namespace

int main(int argc, char **argv)
{
    if (argc > 1 && std::string(argv[1]) == "--starts") {
        return play_lines();
    }
    const long episodes = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 10000;
    std::mt19937_64 random(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0);
    if (episodes < 1) {
        std::fprintf(stderr, "play: no number of episodes: %s\n", argv[1]);
        return 2;
    }
    long adversary = 0, defenders = 0;
    for (long i = 0; i < episodes; i++) {
        std::array<double, 10> position{};
        const int goal = static_cast<int>(random() >> 63);
        for (double &value : position) {
            value = uniform(random);
        }
        const Episode episode = World(goal, position).play();
        adversary += episode.adversary;
        defenders += episode.defenders;
    }
    const double n = static_cast<double>(episodes);
    std::printf("adversaries success r=0.316: %ld of %ld episodes, %.3f\n", adversary, episodes, static_cast<double>(adversary) / n);
    std::printf("defenders success r=0.316: %ld of %ld episodes, %.3f\n", defenders, episodes, static_cast<double>(defenders) / n);
    return 0;
}
