// One period of a flow over many boxes by Flow*, as its users call it: for flowstar.py.
// Reads: the number of variables, a line for each with its name and its derivative; order, step, period, the estimate
// of the remainder; the number of boxes, and the ends of each. Writes a line for each box, the ends of all states at the
// end of the period, or "failed"; then the seconds that all calls of `reach` took.

#include "Continuous.h"

using namespace flowstar;
using namespace std;

int main()
{
	unsigned int size, order;
	double step, period, estimate;
	size_t count;
	cin >> size;
	Variables vars;
	vector<string> rates(size);
	for(auto & rate : rates)
	{
		string name;
		cin >> name;
		getline(cin, rate);
		vars.declareVar(name);
	}
	cin >> order >> step >> period >> estimate >> count;

	ODE<Real> ode(rates, vars);
	Computational_Setting setting(vars);
	setting.setFixedStepsize(step, order);
	setting.setRemainderEstimation(vector<Interval>(size, Interval(-estimate, estimate)));
	setting.printOff();
	vector<Constraint> safeSet;

	clock_t taken = 0;
	cout.precision(17);
	for(size_t k = 0; k < count; ++k)
	{
		vector<Interval> box(size), after;
		for(auto & each : box)
		{
			double low, high;
			cin >> low >> high;
			each = Interval(low, high);
		}
		const clock_t begin = clock();
		Flowpipe initialSet(box);
		Result_of_Reachability result;
		ode.reach(result, initialSet, period, setting, safeSet);
		taken += clock() - begin;
		if(!result.isCompleted())
		{
			cout << "failed\n";
			continue;
		}
		result.fp_end_of_time.intEval(after, order, setting.tm_setting.cutoff_threshold);
		for(const auto & each : after)
			cout << each.inf() << ' ' << each.sup() << ' ';
		cout << '\n';
	}
	cout << (double) taken / CLOCKS_PER_SEC << '\n';
	return 0;
}
