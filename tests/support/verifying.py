"""What several tests use of `maviper.verification.test_verification`."""

from maviper.cli import main


def run(capsys, *arguments):
    code = main.run([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return code, out, err
