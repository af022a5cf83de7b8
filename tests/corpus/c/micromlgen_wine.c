/* exported from a notebook: three inputs, three classes, votes as probabilities */
void predict_proba(const double *x, double out[3])
{
    out[0] = 0.0; out[1] = 0.0; out[2] = 0.0;
    if (x[2] <= 1.5800000429153442) {
        if (x[0] <= 13.0)      { out[1] = 0.25; out[2] = 0.75; }
        else                   { out[2] = 1.0; }
    } else if (x[1] <= 724.5) {
        out[1] = 0.9830508474576272;
        out[0] = 1 - out[1];
    } else {
        out[0] = 0.98; out[1] = 0.02;
    }
}
