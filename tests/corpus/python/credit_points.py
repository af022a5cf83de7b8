"""Points-based credit decision, exported from the notebook of the risk team."""

APPROVE = "approve"
REVIEW = "review"
REJECT = "reject"


def decide(income, debt_ratio, age, late_payments):
    points = 0

    if income > 60_000:
        points += 3
    elif income > 30_000:
        points += 1

    if debt_ratio < 0.35:
        points += 2
    elif debt_ratio > 0.6:
        points -= 2

    if age >= 25:
        points += 1

    if late_payments >= 3:
        points -= 3
    elif late_payments == 0:
        points += 1

    if points >= 5:
        return APPROVE
    if points >= 2:
        return REVIEW
    return REJECT
